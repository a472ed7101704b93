% Made from bed.model by `facetlog model compile`; not to be edited by hand.
% After a change of the model run `make models`.
:- module(bed, []).
:- use_module(facetlog(vocabulary)).
% bed.model:3
model(bed, "A long low broad surface to lie on, with a head at one end.", [lying]).

% bed.model:6  parts
candidate(bed, Thing, Parts) :-
    findall(Parts, likely(bed, Thing, Parts), Found),
    ( Found == [] -> distant(bed, Thing, Parts) ; member(Parts, Found) ).

% bed.model:6  all that may satisfy its lines
likely(bed, Thing, [Lying]) :-
    face_of(Thing, Lying),
    possible(all([measured(Lying), at_most(tilt(Lying), 15), upward(Lying),
                  at_least(cover(Lying), 0.6),
                  at_most(level_length(Lying), 2.6*level_width(Lying)),
                  between(elevation(Lying), 0.08*level_length(Lying), 0.45*level_length(Lying)),
                  at_least(closed_behind(Lying), 0.4),
                  at_most(side_behind(Lying), 0.95*level_length(Lying)),
                  between(protrusion(Lying), 0.15*elevation(Lying), 3*elevation(Lying))])).

% bed.model:6  near misses
distant(bed, Thing, [Lying]) :-
    as_far_as_seen(Thing,
                   [step(Lying, 20,
                         all([measured(Lying), at_most(tilt(Lying), 15), upward(Lying)]))],
                   [Lying]).

% bed.model:8  lying is measured, tilt(lying) at most 15 deg, lying is upward
condition(bed, level, "one lies level", _, [Lying],
          all([measured(Lying), soft(at_most(tilt(Lying), 15), 0.1), upward(Lying)])).
% bed.model:9  cover(lying) at least 60 %
condition(bed, cover, "it takes most of the plan", _, [Lying],
          soft(at_least(cover(Lying), 0.6), 0.1)).
% bed.model:10  level_length(lying) at most 260 % of level_width(lying)
condition(bed, broad, "it is broad enough for a person", _, [Lying],
          soft(at_most(level_length(Lying), 2.6*level_width(Lying)), 0.1)).
% bed.model:11  elevation(lying) between 8 % of level_length(lying) and 45 % of level_length(lying)
condition(bed, low, "it is low for its length", _, [Lying],
          soft(between(elevation(Lying), 0.08*level_length(Lying), 0.45*level_length(Lying)),
               0.1)).
% bed.model:12  closed_behind(lying) at least 40 %, side_behind(lying) at most 95 % of level_length(lying), protrusion(lying) between 15 % of elevation(lying) and 300 % of elevation(lying)
condition(bed, head, "a head rises at a short side of it", _, [Lying],
          all([soft(at_least(closed_behind(Lying), 0.4), 0.1),
               soft(at_most(side_behind(Lying), 0.95*level_length(Lying)), 0.1),
               soft(between(protrusion(Lying), 0.15*elevation(Lying), 3*elevation(Lying)), 0.1)])).
% bed.model:14  level_length(lying) between 160 cm and 230 cm
condition(bed, usual, "people lie down at full length", _, [Lying],
          expect(0.5,
                 if_known(soft(between(level_length(Lying), metres(1.6), metres(2.3)), 0.1)))).

written(bed, level, 'bed.model:8',
        "lying is measured, tilt(lying) at most 15 deg, lying is upward").
written(bed, cover, 'bed.model:9', "cover(lying) at least 60 %").
written(bed, broad, 'bed.model:10', "level_length(lying) at most 260 % of level_width(lying)").
written(bed, low, 'bed.model:11',
        "elevation(lying) between 8 % of level_length(lying) and 45 % of level_length(lying)").
written(bed, head, 'bed.model:12',
        "closed_behind(lying) at least 40 %, side_behind(lying) at most 95 % of level_length(lying), protrusion(lying) between 15 % of elevation(lying) and 300 % of elevation(lying)").
written(bed, usual, 'bed.model:14', "level_length(lying) between 160 cm and 230 cm").

% bed.model:16
size(bed, _, [Lying], length, level_length(Lying)).
% bed.model:17
size(bed, _, [Lying], width, level_width(Lying)).
% bed.model:18
size(bed, _, [Lying], height, elevation(Lying)).
