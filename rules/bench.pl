% Made from bench.model by `facetlog model compile`; not to be edited by hand.
% After a change of the model run `make models`.
:- module(bench, []).
:- use_module(facetlog(vocabulary)).
% bench.model:4
model(bench,
      "A long narrow seat for several, with free space beneath it, with a back or without.",
      [seat]).

% bench.model:7  parts
candidate(bench, Thing, Parts) :-
    findall(Parts, likely(bench, Thing, Parts), Found),
    ( Found == [] -> distant(bench, Thing, Parts) ; member(Parts, Found) ).

% bench.model:7  all that may satisfy its lines
likely(bench, Thing, [Seat]) :-
    face_of(Thing, Seat),
    possible(all([measured(Seat), at_most(tilt(Seat), 20), upward(Seat),
                  at_least(cover(Seat), 0.5), at_least(level_length(Seat), 2*level_width(Seat)),
                  between(elevation(Seat), 0.18*level_length(Seat), 0.55*level_length(Seat)),
                  between(level_width(Seat), 0.4*elevation(Seat), 1.5*elevation(Seat)),
                  at_least(free_below(Seat), 0.5),
                  at_most(protrusion(Seat), 1.5*elevation(Seat)),
                  if_known(at_most(closed_in_front(Seat), 0.35)),
                  if_known(at_most(level_width(Seat), metres(0.55)))])).

% bench.model:7  near misses
distant(bench, Thing, [Seat]) :-
    as_far_as_seen(Thing,
                   [step(Seat, 20, all([measured(Seat), at_most(tilt(Seat), 20), upward(Seat)]))],
                   [Seat]).

% bench.model:9  seat is measured, tilt(seat) at most 20 deg, seat is upward
condition(bench, level, "the seat is about level and faces up", _, [Seat],
          all([measured(Seat), soft(at_most(tilt(Seat), 20), 0.1), upward(Seat)])).
% bench.model:11  cover(seat) at least 50 %
condition(bench, cover, "the seat takes much of the plan", _, [Seat],
          soft(at_least(cover(Seat), 0.5), 0.1)).
% bench.model:12  level_length(seat) at least 200 % of level_width(seat)
condition(bench, long, "it has room for several, one beside the other", _, [Seat],
          soft(at_least(level_length(Seat), 2*level_width(Seat)), 0.1)).
% bench.model:13  elevation(seat) between 18 % of level_length(seat) and 55 % of level_length(seat), level_width(seat) between 40 % of elevation(seat) and 150 % of elevation(seat)
condition(bench, high, "one can sit on it: it is no plank, no pole and no bed", _, [Seat],
          all([soft(between(elevation(Seat), 0.18*level_length(Seat), 0.55*level_length(Seat)),
                    0.1),
               soft(between(level_width(Seat), 0.4*elevation(Seat), 1.5*elevation(Seat)), 0.1)])).
% bench.model:15  free_below(seat) at least 50 %
condition(bench, room, "there is free space beneath the seat", _, [Seat],
          soft(at_least(free_below(Seat), 0.5), 0.1)).
% bench.model:16  protrusion(seat) at most 150 % of elevation(seat)
condition(bench, back, "no more than a back rises above the seat", _, [Seat],
          soft(at_most(protrusion(Seat), 1.5*elevation(Seat)), 0.1)).
% bench.model:17  closed_in_front(seat) at most 35 %
condition(bench, front, "the seat is open in front", _, [Seat],
          if_known(soft(at_most(closed_in_front(Seat), 0.35), 0.1))).
% bench.model:18  level_width(seat) at most 55 cm
condition(bench, seat_size, "seats are at most 55 cm deep", _, [Seat],
          if_known(soft(at_most(level_width(Seat), metres(0.55)), 0.1))).
% bench.model:19  elevation(seat) between 30 cm and 60 cm
condition(bench, usual, "seats are 30 cm to 60 cm high", _, [Seat],
          expect(0.25, if_known(soft(between(elevation(Seat), metres(0.3), metres(0.6)), 0.1)))).

written(bench, level, 'bench.model:9',
        "seat is measured, tilt(seat) at most 20 deg, seat is upward").
written(bench, cover, 'bench.model:11', "cover(seat) at least 50 %").
written(bench, long, 'bench.model:12', "level_length(seat) at least 200 % of level_width(seat)").
written(bench, high, 'bench.model:13',
        "elevation(seat) between 18 % of level_length(seat) and 55 % of level_length(seat), level_width(seat) between 40 % of elevation(seat) and 150 % of elevation(seat)").
written(bench, room, 'bench.model:15', "free_below(seat) at least 50 %").
written(bench, back, 'bench.model:16', "protrusion(seat) at most 150 % of elevation(seat)").
written(bench, front, 'bench.model:17', "closed_in_front(seat) at most 35 %").
written(bench, seat_size, 'bench.model:18', "level_width(seat) at most 55 cm").
written(bench, usual, 'bench.model:19', "elevation(seat) between 30 cm and 60 cm").

% bench.model:21
size(bench, _, [Seat], length, level_length(Seat)).
% bench.model:22
size(bench, _, [Seat], depth, level_width(Seat)).
% bench.model:23
size(bench, _, [Seat], height, elevation(Seat)).
