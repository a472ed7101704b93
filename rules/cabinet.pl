% Made from cabinet.model by `facetlog model compile`; not to be edited by hand.
% After a change of the model run `make models`.
:- module(cabinet, []).
:- use_module(facetlog(vocabulary)).
% cabinet.model:5
model(cabinet,
      "A closed upright block on the floor, higher than deep, on a plinth, feet or its own sides.",
      [top, front]).

% cabinet.model:5
rather_than(cabinet, box).

% cabinet.model:13  parts
candidate(cabinet, Thing, Parts) :-
    findall(Parts, likely(cabinet, Thing, Parts), Found),
    ( Found == [] -> distant(cabinet, Thing, Parts) ; member(Parts, Found) ).

% cabinet.model:13  all that may satisfy its lines
likely(cabinet, Thing, [Top, Front]) :-
    face_of(Thing, Top),
    possible(all([measured(Top), level(Top), upward(Top), at_least(share(Top), 0.8),
                  at_most(protrusion(Top), 0.05*thing_length(Thing)),
                  at_least(thing_height(Thing), 1.2*width(Top)),
                  at_least(width(Top), 0.12*thing_height(Thing))])),
    face_of(Thing, Front),
    Front \== Top,
    possible(all([measured(Front), upright(Front), at_least(share(Front), 0.6),
                  at_least(fill(Front), 0.8),
                  at_most(protrusion(Front), 0.05*thing_length(Thing)),
                  at_least(width(Front), 0.12*thing_height(Thing))])).

% cabinet.model:13  near misses
distant(cabinet, Thing, [Top, Front]) :-
    as_far_as_seen(Thing,
                   [step(Top, 10, all([measured(Top), level(Top), upward(Top)])),
                    step(Front, 4, all([measured(Front), upright(Front)]))],
                   [Top, Front]).

% cabinet.model:14  leg is upright, bottom_of(leg) at most 5 % of height(this), top_of(leg) between 3 % of height(this) and 40 % of height(this)
means('cabinet.leg'(Leg, Thing),
      all([upright(Leg), soft(at_most(bottom_of(Leg), 0.05*thing_height(Thing)), 0.1),
           soft(between(top_of(Leg), 0.03*thing_height(Thing), 0.4*thing_height(Thing)), 0.1)])).

% cabinet.model:14
members(cabinet, leg, Thing, [Top, Front], Members) :-
    findall(Leg,
            ( element_of(Thing, Leg), \+ memberchk(Leg, [Top, Front]),
              possible('cabinet.leg'(Leg, Thing)) ), Found),
    sort(Found, Members).

% cabinet.model:18  top is measured, top is level, top is upward, share(top) at least 80 %
condition(cabinet, level, "the top is level, faces up and covers it", _, [Top, _],
          all([measured(Top), level(Top), upward(Top), soft(at_least(share(Top), 0.8), 0.1)])).
% cabinet.model:20  front is measured, front is upright, share(front) at least 60 %, fill(front) at least 80 %
condition(cabinet, upright, "the front is upright and closed, down to the feet", _, [_, Front],
          all([measured(Front), upright(Front), soft(at_least(share(Front), 0.6), 0.1),
               soft(at_least(fill(Front), 0.8), 0.1)])).
% cabinet.model:22  each x of top, front: protrusion(x) at most 5 % of length(this)
condition(cabinet, flush, "nothing sticks out past them", Thing, [Top, Front],
          each(X, [Top, Front], soft(at_most(protrusion(X), 0.05*thing_length(Thing)), 0.1))).
% cabinet.model:23  solidity(this) at least 70 %, hollow_side(this) at most 40 %
condition(cabinet, solid, "it fills the box round it, and none of its sides is hollow", Thing,
          [_, _],
          all([soft(at_least(solidity(Thing), 0.7), 0.1),
               soft(at_most(hollow_side(Thing), 0.4), 0.1)])).
% cabinet.model:25  height(this) at least 120 % of width(top), (each x of top, front: width(x) at least 12 % of height(this))
condition(cabinet, tall, "it is higher than deep, and no board or door", Thing, [Top, Front],
          all([soft(at_least(thing_height(Thing), 1.2*width(Top)), 0.1),
               each(X, [Top, Front], soft(at_least(width(X), 0.12*thing_height(Thing)), 0.1))])).
% cabinet.model:27  curved(this) at most 25 %, (each face f where area(f) at least 10 % of length(this) * width(this): along(f))
condition(cabinet, flat, "its surface is flat, and lies along its sides", Thing, [Top, Front],
          all([soft(at_most(curved(Thing), 0.25), 0.1),
               each(F, Fs,
                    implies(soft(at_least(area(F), 0.1*thing_length(Thing)*thing_width(Thing)),
                                 0.1),
                            any([parallel(F, Top, 15), parallel(F, Front, 15),
                                 all([soft(near(angle(F, Top), 90, 15), 0.1),
                                      soft(near(angle(F, Front), 90, 15), 0.1)])])))])) :-
    findall(F,
            ( face_of(Thing, F), \+ memberchk(F, [Top, Front]),
              possible(at_least(area(F), 0.1*thing_length(Thing)*thing_width(Thing))) ),
            Found),
    sort(Found, Fs).
% cabinet.model:29  count(leg) at least 1
condition(cabinet, raised, "cabinets stand on a plinth or feet", Thing, [Top, Front],
          expect(0.1, at_least_of(1, Leg, Leg_groups, 'cabinet.leg'(Leg, Thing)))) :-
    members(cabinet, leg, Thing, [Top, Front], Leg_members),
    separate(Leg_members, Leg_groups).
% cabinet.model:30  height(this) between 50 cm and 260 cm
condition(cabinet, usual, "cabinets are 50 cm to 260 cm high", Thing, [_, _],
          expect(0.5,
                 if_known(soft(between(thing_height(Thing), metres(0.5), metres(2.6)), 0.1)))).

written(cabinet, level, 'cabinet.model:18',
        "top is measured, top is level, top is upward, share(top) at least 80 %").
written(cabinet, upright, 'cabinet.model:20',
        "front is measured, front is upright, share(front) at least 60 %, fill(front) at least 80 %").
written(cabinet, flush, 'cabinet.model:22',
        "each x of top, front: protrusion(x) at most 5 % of length(this)").
written(cabinet, solid, 'cabinet.model:23',
        "solidity(this) at least 70 %, hollow_side(this) at most 40 %").
written(cabinet, tall, 'cabinet.model:25',
        "height(this) at least 120 % of width(top), (each x of top, front: width(x) at least 12 % of height(this))").
written(cabinet, flat, 'cabinet.model:27',
        "curved(this) at most 25 %, (each face f where area(f) at least 10 % of length(this) * width(this): along(f))").
written(cabinet, raised, 'cabinet.model:29', "count(leg) at least 1").
written(cabinet, usual, 'cabinet.model:30', "height(this) between 50 cm and 260 cm").

% cabinet.model:14
group(cabinet, Thing, [Top, Front], leg, Members) :-
    members(cabinet, leg, Thing, [Top, Front], Leg_members),
    findall(Leg, ( member(Leg, Leg_members), holds('cabinet.leg'(Leg, Thing)) ), Members).

% cabinet.model:32
size(cabinet, _, [Top, _], width, length(Top)).
% cabinet.model:33
size(cabinet, _, [Top, _], depth, width(Top)).
% cabinet.model:34
size(cabinet, Thing, [_, _], height, thing_height(Thing)).
