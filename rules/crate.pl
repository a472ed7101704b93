% Made from crate.model by `facetlog model compile`; not to be edited by hand.
% After a change of the model run `make models`.
:- module(crate, []).
:- use_module(facetlog(vocabulary)).
% crate.model:4
model(crate, "An open box: a level floor, walls all round it, and nothing above.", [floor]).

% crate.model:7  parts
candidate(crate, Thing, Parts) :-
    findall(Parts, likely(crate, Thing, Parts), Found),
    ( Found == [] -> distant(crate, Thing, Parts) ; member(Parts, Found) ).

% crate.model:7  all that may satisfy its lines
likely(crate, Thing, [Floor]) :-
    face_of(Thing, Floor),
    possible(all([measured(Floor), level(Floor), upward(Floor),
                  at_most(elevation(Floor), 0.25*thing_height(Thing)),
                  at_least(cover(Floor), 0.55), at_least(enclosed(Floor), 0.85),
                  at_most(built_over(Floor), 0.2)])).

% crate.model:7  near misses
distant(crate, Thing, [Floor]) :-
    as_far_as_seen(Thing,
                   [step(Floor, 20, all([measured(Floor), level(Floor), upward(Floor)]))],
                   [Floor]).

% crate.model:9  floor is measured, floor is level, floor is upward
condition(crate, level, "the floor lies level", _, [Floor],
          all([measured(Floor), level(Floor), upward(Floor)])).
% crate.model:10  elevation(floor) at most 25 % of height(this)
condition(crate, low, "the floor is at the bottom", Thing, [Floor],
          soft(at_most(elevation(Floor), 0.25*thing_height(Thing)), 0.1)).
% crate.model:11  cover(floor) at least 55 %
condition(crate, broad, "the floor takes most of the plan", _, [Floor],
          soft(at_least(cover(Floor), 0.55), 0.1)).
% crate.model:12  enclosed(floor) at least 85 %
condition(crate, walls, "walls rise all round the floor", _, [Floor],
          soft(at_least(enclosed(Floor), 0.85), 0.1)).
% crate.model:13  built_over(floor) at most 20 %
condition(crate, open, "it is open above", _, [Floor],
          soft(at_most(built_over(Floor), 0.2), 0.1)).
% crate.model:14  height(this) at least 15 % of length(this)
condition(crate, deep, "it is no tray", Thing, [_],
          soft(at_least(thing_height(Thing), 0.15*thing_length(Thing)), 0.1)).
% crate.model:15  curved(this) at most 25 %
condition(crate, flat, "its walls are flat", Thing, [_], soft(at_most(curved(Thing), 0.25), 0.1)).

written(crate, level, 'crate.model:9', "floor is measured, floor is level, floor is upward").
written(crate, low, 'crate.model:10', "elevation(floor) at most 25 % of height(this)").
written(crate, broad, 'crate.model:11', "cover(floor) at least 55 %").
written(crate, walls, 'crate.model:12', "enclosed(floor) at least 85 %").
written(crate, open, 'crate.model:13', "built_over(floor) at most 20 %").
written(crate, deep, 'crate.model:14', "height(this) at least 15 % of length(this)").
written(crate, flat, 'crate.model:15', "curved(this) at most 25 %").

% crate.model:17
size(crate, Thing, [_], length, thing_length(Thing)).
% crate.model:18
size(crate, _, [Floor], width, level_width(Floor)).
% crate.model:19
size(crate, Thing, [_], height, thing_height(Thing)).
