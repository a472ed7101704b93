% Made from step_stool.model by `facetlog model compile`; not to be edited by hand.
% After a change of the model run `make models`.
:- module(step_stool, []).
:- use_module(facetlog(vocabulary)).
% step_stool.model:3
model(step_stool, "Two treads, the lower before the higher, to reach what is too high.",
      [low, high]).

% step_stool.model:9  parts
candidate(step_stool, Thing, Parts) :-
    findall(Parts, likely(step_stool, Thing, Parts), Found),
    ( Found == [] -> distant(step_stool, Thing, Parts) ; member(Parts, Found) ).

% step_stool.model:9  all that may satisfy its lines
likely(step_stool, Thing, [Low, High]) :-
    face_of(Thing, Low),
    possible(all([measured(Low), level(Low), upward(Low), between(share(Low), 0.2, 0.75)])),
    face_of(Thing, High),
    High \== Low,
    possible(all([measured(High), level(High), upward(High), between(share(High), 0.2, 0.75),
                  at_most(protrusion(High), 0.1*elevation(High))])),
    possible(all([between(elevation(Low), 0.35*elevation(High), 0.65*elevation(High)),
                  if_known(at_most(overlap(Low, High), 0.2)),
                  between(length(Low), 0.8*length(High), 1.2*length(High))])).

% step_stool.model:9  near misses
distant(step_stool, Thing, [Low, High]) :-
    as_far_as_seen(Thing,
                   [step(Low, 10, all([measured(Low), level(Low), upward(Low)])),
                    step(High, 4, all([measured(High), level(High), upward(High)]))],
                   [Low, High]).

% step_stool.model:11  each x of low, high: x is measured, x is level, x is upward, share(x) between 20 % and 75 %
condition(step_stool, level, "two level treads face up, each a part of the plan", _,
          [Low, High],
          each(X, [Low, High],
               all([measured(X), level(X), upward(X), soft(between(share(X), 0.2, 0.75), 0.1)]))).
% step_stool.model:13  elevation(low) between 35 % of elevation(high) and 65 % of elevation(high)
condition(step_stool, half, "the lower is about half as high", _, [Low, High],
          soft(between(elevation(Low), 0.35*elevation(High), 0.65*elevation(High)), 0.1)).
% step_stool.model:14  overlap(low, high) at most 20 %
condition(step_stool, beside, "it lies before the higher", _, [Low, High],
          if_known(soft(at_most(overlap(Low, High), 0.2), 0.1))).
% step_stool.model:15  length(low) = length(high) ± 20 %
condition(step_stool, alike, "they are equally long", _, [Low, High],
          soft(between(length(Low), 0.8*length(High), 1.2*length(High)), 0.1)).
% step_stool.model:16  protrusion(high) at most 10 % of elevation(high)
condition(step_stool, top, "nothing rises above the higher", _, [_, High],
          soft(at_most(protrusion(High), 0.1*elevation(High)), 0.1)).
% step_stool.model:17  there is no face other where tread(other)
condition(step_stool, two, "there is no third", Thing, [Low, High],
          not(some(Other, Others,
                   all([level(Other), upward(Other), below(Other, High),
                        soft(at_least(elevation(Other), 0.1*elevation(High)), 0.1)])))) :-
    findall(Other,
            ( face_of(Thing, Other), \+ memberchk(Other, [Low, High]),
              possible(all([level(Other), upward(Other), below(Other, High),
                            at_least(elevation(Other), 0.1*elevation(High))])) ),
            Found),
    sort(Found, Others).
% step_stool.model:18  elevation(high) between 25 cm and 70 cm
condition(step_stool, usual, "it is about knee-high", _, [_, High],
          expect(0.25, if_known(soft(between(elevation(High), metres(0.25), metres(0.7)), 0.1)))).

written(step_stool, level, 'step_stool.model:11',
        "each x of low, high: x is measured, x is level, x is upward, share(x) between 20 % and 75 %").
written(step_stool, half, 'step_stool.model:13',
        "elevation(low) between 35 % of elevation(high) and 65 % of elevation(high)").
written(step_stool, beside, 'step_stool.model:14', "overlap(low, high) at most 20 %").
written(step_stool, alike, 'step_stool.model:15', "length(low) = length(high) ± 20 %").
written(step_stool, top, 'step_stool.model:16',
        "protrusion(high) at most 10 % of elevation(high)").
written(step_stool, two, 'step_stool.model:17', "there is no face other where tread(other)").
written(step_stool, usual, 'step_stool.model:18', "elevation(high) between 25 cm and 70 cm").

% step_stool.model:20
size(step_stool, _, [_, High], length, length(High)).
% step_stool.model:21
size(step_stool, _, [_, High], height, elevation(High)).
