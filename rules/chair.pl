% Made from chair.model by `facetlog model compile`; not to be edited by hand.
% After a change of the model run `make models`.
:- module(chair, []).
:- use_module(facetlog(vocabulary)).
% chair.model:4
model(chair, "A level seat on legs, with an upright back rising above one side of it.",
      [seat, back]).

% chair.model:14  parts
candidate(chair, Thing, Parts) :-
    findall(Parts, likely(chair, Thing, Parts), Found),
    ( Found == [] -> distant(chair, Thing, Parts) ; member(Parts, Found) ).

% chair.model:14  all that may satisfy its lines
likely(chair, Thing, [Seat, Back]) :-
    face_of(Thing, Seat),
    possible(all([measured(Seat), at_most(tilt(Seat), 20), upward(Seat),
                  between(protrusion(Seat), 0.33*elevation(Seat), 4*elevation(Seat)),
                  if_known(at_most(closed_in_front(Seat), 0.35)),
                  at_least(level_width(Seat), 0.4*elevation(Seat)),
                  at_most(level_length(Seat), 1.8*level_width(Seat)),
                  at_least(elevation(Seat), 0.35*level_length(Seat))])),
    ( findall(Back,
              ( face_of(Thing, Back), Back \== Seat,
                possible(all([at_least(tilt(Back), 65),
                              at_least(top_of(Back), 1.3*elevation(Seat)),
                              at_least(length(Back), 0.5*width(Seat)),
                              any([at_least(offset(Seat, Back), 0.3*width(Seat)),
                                   at_most(offset(Seat, Back), -(0.3*width(Seat)))])])) ),
              Backs), member(Back, [unseen|Backs]) ).

% chair.model:14  near misses
distant(chair, Thing, [Seat, Back]) :-
    as_far_as_seen(Thing,
                   [step(Seat, 10, all([measured(Seat), at_most(tilt(Seat), 20), upward(Seat)]))],
                   [Seat]),
    Back = unseen.

% chair.model:16  leg supports seat
means('chair.leg'(Leg, Seat), supports(Leg, Seat)).

% chair.model:16
members(chair, leg, Thing, [Seat, Back], Members) :-
    findall(Leg,
            ( element_of(Thing, Leg), \+ memberchk(Leg, [Seat, Back]),
              possible('chair.leg'(Leg, Seat)) ), Found),
    sort(Found, Members).

% chair.model:15  optional face back where is_back(back)
condition(chair, back, "an upright back stands at the rim of the seat", _, [Seat, Back],
          all([soft(at_least(tilt(Back), 65), 0.1),
               soft(at_least(top_of(Back), 1.3*elevation(Seat)), 0.1),
               soft(at_least(length(Back), 0.5*width(Seat)), 0.1),
               any([soft(at_least(offset(Seat, Back), 0.3*width(Seat)), 0.1),
                    soft(at_most(offset(Seat, Back), -(0.3*width(Seat))), 0.1)])])) :-
    Back \== unseen.
% chair.model:18  seat is measured, tilt(seat) at most 20 deg, seat is upward
condition(chair, level, "the seat is about level and faces up", _, [Seat, _],
          all([measured(Seat), soft(at_most(tilt(Seat), 20), 0.1), upward(Seat)])).
% chair.model:22  cover(seat) at least 50 % and (free_below(seat) at least 50 % or room_width(seat) at least 60 % of elevation(seat)) or cover(seat) at least 30 % and see_through(seat) at most 35 % or count(leg) at least 3
condition(chair, cover, "the seat takes much of the plan", Thing, [Seat, Back],
          any([all([soft(at_least(cover(Seat), 0.5), 0.1),
                    any([soft(at_least(free_below(Seat), 0.5), 0.1),
                         soft(at_least(room_width(Seat), 0.6*elevation(Seat)), 0.1)])]),
               all([soft(at_least(cover(Seat), 0.3), 0.1),
                    soft(at_most(see_through(Seat), 0.35), 0.1)]),
               at_least_of(3, Leg, Leg_groups, 'chair.leg'(Leg, Seat))])) :-
    members(chair, leg, Thing, [Seat, Back], Leg_members),
    separate(Leg_members, Leg_groups).
% chair.model:26  protrusion(seat) between 33 % of elevation(seat) and 400 % of elevation(seat)
condition(chair, rises, "something rises above the seat, which is at about half of the height",
          _, [Seat, _],
          soft(between(protrusion(Seat), 0.33*elevation(Seat), 4*elevation(Seat)), 0.1)).
% chair.model:27  closed_in_front(seat) at most 35 %
condition(chair, front, "the seat is open in front", _, [Seat, _],
          if_known(soft(at_most(closed_in_front(Seat), 0.35), 0.1))).
% chair.model:29  closed_behind(seat) at least 70 % or (there is a face f where is_back(f))
condition(chair, backed, "a back rises at one side of the seat, about as broad as that", Thing,
          [Seat, Back],
          any([soft(at_least(closed_behind(Seat), 0.7), 0.1),
               some(F, Fs,
                    all([soft(at_least(tilt(F), 65), 0.1),
                         soft(at_least(top_of(F), 1.3*elevation(Seat)), 0.1),
                         soft(at_least(length(F), 0.5*width(Seat)), 0.1),
                         any([soft(at_least(offset(Seat, F), 0.3*width(Seat)), 0.1),
                              soft(at_most(offset(Seat, F), -(0.3*width(Seat))), 0.1)])]))])) :-
    findall(F,
            ( face_of(Thing, F), \+ memberchk(F, [Seat, Back]),
              possible(all([at_least(tilt(F), 65), at_least(top_of(F), 1.3*elevation(Seat)),
                            at_least(length(F), 0.5*width(Seat)),
                            any([at_least(offset(Seat, F), 0.3*width(Seat)),
                                 at_most(offset(Seat, F), -(0.3*width(Seat)))])])) ),
            Found),
    sort(Found, Fs).
% chair.model:32  level_width(seat) at least 40 % of elevation(seat), level_length(seat) at most 180 % of level_width(seat), height(this) at least 50 % of length(this), elevation(seat) at least 35 % of level_length(seat)
condition(chair, proportion, "the seat is no bar stool's, no bench's and no bed's", Thing,
          [Seat, _],
          all([soft(at_least(level_width(Seat), 0.4*elevation(Seat)), 0.1),
               soft(at_most(level_length(Seat), 1.8*level_width(Seat)), 0.1),
               soft(at_least(thing_height(Thing), 0.5*thing_length(Thing)), 0.1),
               soft(at_least(elevation(Seat), 0.35*level_length(Seat)), 0.1)])).
% chair.model:36  elevation(seat) between 30 cm and 60 cm
condition(chair, usual, "seats are 30 cm to 60 cm high", _, [Seat, _],
          expect(0.25, if_known(soft(between(elevation(Seat), metres(0.3), metres(0.6)), 0.1)))).

written(chair, back, 'chair.model:15', "optional face back where is_back(back)").
written(chair, level, 'chair.model:18',
        "seat is measured, tilt(seat) at most 20 deg, seat is upward").
written(chair, cover, 'chair.model:22',
        "cover(seat) at least 50 % and (free_below(seat) at least 50 % or room_width(seat) at least 60 % of elevation(seat)) or cover(seat) at least 30 % and see_through(seat) at most 35 % or count(leg) at least 3").
written(chair, rises, 'chair.model:26',
        "protrusion(seat) between 33 % of elevation(seat) and 400 % of elevation(seat)").
written(chair, front, 'chair.model:27', "closed_in_front(seat) at most 35 %").
written(chair, backed, 'chair.model:29',
        "closed_behind(seat) at least 70 % or (there is a face f where is_back(f))").
written(chair, proportion, 'chair.model:32',
        "level_width(seat) at least 40 % of elevation(seat), level_length(seat) at most 180 % of level_width(seat), height(this) at least 50 % of length(this), elevation(seat) at least 35 % of level_length(seat)").
written(chair, usual, 'chair.model:36', "elevation(seat) between 30 cm and 60 cm").

% chair.model:16
group(chair, Thing, [Seat, Back], leg, Members) :-
    members(chair, leg, Thing, [Seat, Back], Leg_members),
    findall(Leg, ( member(Leg, Leg_members), holds('chair.leg'(Leg, Seat)) ), Members).

% chair.model:38
size(chair, _, [Seat, _], width, front_width(Seat)).
% chair.model:39
size(chair, _, [Seat, _], depth, front_depth(Seat)).
% chair.model:40
size(chair, _, [Seat, _], seat_height, elevation(Seat)).
% chair.model:41
size(chair, Thing, [_, _], height, thing_height(Thing)).
