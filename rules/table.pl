% Made from table.model by `facetlog model compile`; not to be edited by hand.
% After a change of the model run `make models`.
:- module(table, []).
:- use_module(facetlog(vocabulary)).
% table.model:4
model(table, "A level top with free space beneath it, on legs or panels that reach the ground.",
      [top]).

% table.model:7  parts
candidate(table, Thing, Parts) :-
    findall(Parts, likely(table, Thing, Parts), Found),
    ( Found == [] -> distant(table, Thing, Parts) ; member(Parts, Found) ).

% table.model:7  all that may satisfy its lines
likely(table, Thing, [Top]) :-
    face_of(Thing, Top),
    possible(all([measured(Top), level(Top), upward(Top), at_least(cover(Top), 0.75),
                  at_most(protrusion(Top), 0.4*elevation(Top)), at_least(free_below(Top), 0.6),
                  at_least(open_from_two_sides(Top), 0.3),
                  at_least(level_width(Top), 0.35*elevation(Top)),
                  at_least(elevation(Top), 0.12*level_length(Top))])).

% table.model:7  near misses
distant(table, Thing, [Top]) :-
    as_far_as_seen(Thing, [step(Top, 20, all([measured(Top), level(Top), upward(Top)]))], [Top]).

% table.model:9  top is measured, top is level, top is upward
condition(table, level, "the top is level and faces up", _, [Top],
          all([measured(Top), level(Top), upward(Top)])).
% table.model:10  cover(top) at least 75 %
condition(table, cover, "the top covers the thing seen from above", _, [Top],
          soft(at_least(cover(Top), 0.75), 0.1)).
% table.model:12  protrusion(top) at most 40 % of elevation(top)
condition(table, topmost, "nothing rises above the top but what may stand on it", _, [Top],
          soft(at_most(protrusion(Top), 0.4*elevation(Top)), 0.1)).
% table.model:14  free_below(top) at least 60 %
condition(table, room, "there is free space beneath the top", _, [Top],
          soft(at_least(free_below(Top), 0.6), 0.1)).
% table.model:15  open_from_two_sides(top) at least 30 %
condition(table, open, "one sees in beneath it from two sides", _, [Top],
          soft(at_least(open_from_two_sides(Top), 0.3), 0.1)).
% table.model:17  level_width(top) at least 35 % of elevation(top), elevation(top) at least 12 % of level_length(top)
condition(table, proportion, "the top is no pole and no tray", _, [Top],
          all([soft(at_least(level_width(Top), 0.35*elevation(Top)), 0.1),
               soft(at_least(elevation(Top), 0.12*level_length(Top)), 0.1)])).
% table.model:19  elevation(top) between 30 cm and 120 cm
condition(table, usual, "tables are 30 cm to 120 cm high", _, [Top],
          expect(0.25, if_known(soft(between(elevation(Top), metres(0.3), metres(1.2)), 0.1)))).

written(table, level, 'table.model:9', "top is measured, top is level, top is upward").
written(table, cover, 'table.model:10', "cover(top) at least 75 %").
written(table, topmost, 'table.model:12', "protrusion(top) at most 40 % of elevation(top)").
written(table, room, 'table.model:14', "free_below(top) at least 60 %").
written(table, open, 'table.model:15', "open_from_two_sides(top) at least 30 %").
written(table, proportion, 'table.model:17',
        "level_width(top) at least 35 % of elevation(top), elevation(top) at least 12 % of level_length(top)").
written(table, usual, 'table.model:19', "elevation(top) between 30 cm and 120 cm").

% table.model:21
size(table, _, [Top], length, length(Top)).
% table.model:22
size(table, _, [Top], width, width(Top)).
% table.model:23
size(table, _, [Top], height, elevation(Top)).
