% Made from door.model by `facetlog model compile`; not to be edited by hand.
% After a change of the model run `make models`.
:- module(door, []).
:- use_module(facetlog(vocabulary)).
% door.model:4
model(door, "An upright leaf, thin, and higher than broad.", [leaf]).

% door.model:7  parts
candidate(door, Thing, Parts) :-
    findall(Parts, likely(door, Thing, Parts), Found),
    ( Found == [] -> distant(door, Thing, Parts) ; member(Parts, Found) ).

% door.model:7  all that may satisfy its lines
likely(door, Thing, [Leaf]) :-
    face_of(Thing, Leaf),
    possible(all([measured(Leaf), upright(Leaf), at_least(fill(Leaf), 0.6),
                  at_least(area(Leaf), 0.25*thing_height(Thing)*thing_width(Thing))])).

% door.model:7  near misses
distant(door, Thing, [Leaf]) :-
    as_far_as_seen(Thing, [step(Leaf, 20, all([measured(Leaf), upright(Leaf)]))], [Leaf]).

% door.model:9  leaf is measured, leaf is upright, fill(leaf) at least 60 %, area(leaf) at least 25 % of height(this) * width(this)
condition(door, upright, "an upright leaf is much of what one sees from before it", Thing,
          [Leaf],
          all([measured(Leaf), upright(Leaf), soft(at_least(fill(Leaf), 0.6), 0.1),
               soft(at_least(area(Leaf), 0.25*thing_height(Thing)*thing_width(Thing)), 0.1)])).
% door.model:11  depth(this) at most 20 % of width(this)
condition(door, thin, "it is thin", Thing, [_],
          soft(at_most(depth(Thing), 0.2*thing_width(Thing)), 0.1)).
% door.model:12  height(this) between 130 % of width(this) and 400 % of width(this), height(this) at least 90 % of length(this)
condition(door, tall, "it is higher than broad", Thing, [_],
          all([soft(between(thing_height(Thing), 1.3*thing_width(Thing), 4*thing_width(Thing)),
                    0.1),
               soft(at_least(thing_height(Thing), 0.9*thing_length(Thing)), 0.1)])).
% door.model:14  solidity(this) at least 40 %
condition(door, closed, "it is mostly closed", Thing, [_],
          soft(at_least(solidity(Thing), 0.4), 0.1)).
% door.model:15  height(this) between 170 cm and 270 cm
condition(door, usual, "people walk through upright", Thing, [_],
          expect(0.5,
                 if_known(soft(between(thing_height(Thing), metres(1.7), metres(2.7)), 0.1)))).

written(door, upright, 'door.model:9',
        "leaf is measured, leaf is upright, fill(leaf) at least 60 %, area(leaf) at least 25 % of height(this) * width(this)").
written(door, thin, 'door.model:11', "depth(this) at most 20 % of width(this)").
written(door, tall, 'door.model:12',
        "height(this) between 130 % of width(this) and 400 % of width(this), height(this) at least 90 % of length(this)").
written(door, closed, 'door.model:14', "solidity(this) at least 40 %").
written(door, usual, 'door.model:15', "height(this) between 170 cm and 270 cm").

% door.model:17
size(door, Thing, [_], width, thing_width(Thing)).
% door.model:18
size(door, Thing, [_], height, thing_height(Thing)).
