% Made from sofa.model by `facetlog model compile`; not to be edited by hand.
% After a change of the model run `make models`.
:- module(sofa, []).
:- use_module(facetlog(vocabulary)).
% sofa.model:4
model(sofa, "A long stuffed seat with a back along it, for two or more.", [seat]).

% sofa.model:9  parts
candidate(sofa, Thing, Parts) :-
    findall(Parts, likely(sofa, Thing, Parts), Found),
    ( Found == [] -> distant(sofa, Thing, Parts) ; member(Parts, Found) ).

% sofa.model:9  all that may satisfy its lines
likely(sofa, Thing, [Seat]) :-
    face_of(Thing, Seat),
    possible(all([measured(Seat), at_most(tilt(Seat), 20), upward(Seat),
                  at_least(cover(Seat), 0.3),
                  between(elevation(Seat), 0.15*level_length(Seat), 0.5*level_length(Seat)),
                  at_least(closed_behind(Seat), 0.7),
                  at_least(side_behind(Seat), 0.9*level_length(Seat)),
                  between(protrusion(Seat), 0.33*elevation(Seat), 3*elevation(Seat)),
                  if_known(at_most(closed_in_front(Seat), 0.35)),
                  at_most(see_through(Seat), 0.4)])).

% sofa.model:9  near misses
distant(sofa, Thing, [Seat]) :-
    as_far_as_seen(Thing,
                   [step(Seat, 20, all([measured(Seat), at_most(tilt(Seat), 20), upward(Seat)]))],
                   [Seat]).

% sofa.model:11  seat is measured, tilt(seat) at most 20 deg, seat is upward
condition(sofa, level, "the seat is about level and faces up", _, [Seat],
          all([measured(Seat), soft(at_most(tilt(Seat), 20), 0.1), upward(Seat)])).
% sofa.model:13  cover(seat) at least 30 %
condition(sofa, cover, "the seat takes much of the plan", _, [Seat],
          soft(at_least(cover(Seat), 0.3), 0.1)).
% sofa.model:14  length(this) at least 170 % of height(this)
condition(sofa, long, "it has room for two, one beside the other", Thing, [_],
          soft(at_least(thing_length(Thing), 1.7*thing_height(Thing)), 0.1)).
% sofa.model:15  elevation(seat) between 15 % of level_length(seat) and 50 % of level_length(seat)
condition(sofa, low, "it is as low as a seat", _, [Seat],
          soft(between(elevation(Seat), 0.15*level_length(Seat), 0.5*level_length(Seat)), 0.1)).
% sofa.model:16  closed_behind(seat) at least 70 %, side_behind(seat) at least 90 % of level_length(seat)
condition(sofa, backed, "a back stands along its long side", _, [Seat],
          all([soft(at_least(closed_behind(Seat), 0.7), 0.1),
               soft(at_least(side_behind(Seat), 0.9*level_length(Seat)), 0.1)])).
% sofa.model:18  protrusion(seat) between 33 % of elevation(seat) and 300 % of elevation(seat)
condition(sofa, rises, "the back rises above the seat", _, [Seat],
          soft(between(protrusion(Seat), 0.33*elevation(Seat), 3*elevation(Seat)), 0.1)).
% sofa.model:19  closed_in_front(seat) at most 35 %
condition(sofa, front, "the seat is open in front", _, [Seat],
          if_known(soft(at_most(closed_in_front(Seat), 0.35), 0.1))).
% sofa.model:20  see_through(seat) at most 40 %
condition(sofa, stuffed, "one does not see through beneath it", _, [Seat],
          soft(at_most(see_through(Seat), 0.4), 0.1)).
% sofa.model:22  there is no face f where alike(f)
condition(sofa, last, "nothing like the seat lies above it", Thing, [Seat],
          not(some(F, Fs,
                   all([level(F), upward(F), above(F, Seat),
                        soft(at_least(area(F), 0.6*area(Seat)), 0.1)])))) :-
    findall(F,
            ( face_of(Thing, F), \+ memberchk(F, [Seat]),
              possible(all([level(F), upward(F), above(F, Seat),
                            at_least(area(F), 0.6*area(Seat))])) ), Found),
    sort(Found, Fs).
% sofa.model:23  elevation(seat) between 25 cm and 60 cm
condition(sofa, usual, "seats are 25 cm to 60 cm high", _, [Seat],
          expect(0.25, if_known(soft(between(elevation(Seat), metres(0.25), metres(0.6)), 0.1)))).

written(sofa, level, 'sofa.model:11',
        "seat is measured, tilt(seat) at most 20 deg, seat is upward").
written(sofa, cover, 'sofa.model:13', "cover(seat) at least 30 %").
written(sofa, long, 'sofa.model:14', "length(this) at least 170 % of height(this)").
written(sofa, low, 'sofa.model:15',
        "elevation(seat) between 15 % of level_length(seat) and 50 % of level_length(seat)").
written(sofa, backed, 'sofa.model:16',
        "closed_behind(seat) at least 70 %, side_behind(seat) at least 90 % of level_length(seat)").
written(sofa, rises, 'sofa.model:18',
        "protrusion(seat) between 33 % of elevation(seat) and 300 % of elevation(seat)").
written(sofa, front, 'sofa.model:19', "closed_in_front(seat) at most 35 %").
written(sofa, stuffed, 'sofa.model:20', "see_through(seat) at most 40 %").
written(sofa, last, 'sofa.model:22', "there is no face f where alike(f)").
written(sofa, usual, 'sofa.model:23', "elevation(seat) between 25 cm and 60 cm").

% sofa.model:25
size(sofa, Thing, [_], length, thing_length(Thing)).
% sofa.model:26
size(sofa, _, [Seat], seat_height, elevation(Seat)).
% sofa.model:27
size(sofa, Thing, [_], height, thing_height(Thing)).
