:- module(facetlog_ask, [ is_a/2,             % ?Thing, ?Model
                          verdict/4,          % ?Thing, ?Model, ?State, ?Degree
                          plays/4,            % ?Face, ?Role, ?Thing, ?Model
                          assignment/3        % ?Model, ?Thing, ?Parts
                        ]).

/** <module> Verdicts as relations

Of the current scene, for all loaded models. A verdict is found when it is first asked for and
remembered with the scene.
*/

:- use_module(library(lists)).
:- use_module(library(solution_sequences)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog_kb(named_models)).
:- use_module(facetlog_kb(judge)).
:- use_module(facetlog_kb(code)).
:- use_module(facetlog_kb(specialise)).
:- use_module(facetlog_kb(search)).
:- use_module(facetlog_kb(in_progress)).
:- use_module(facetlog_kb(model_descriptions)).

%!  is_a(?Thing, ?Model) is nondet.
%
%   Model holds for Thing.

is_a(Thing, Model) :-
    judged(Thing, Model, Module),
    standing(Module, Model, Thing, standing(holds, _)).

%!  verdict(?Thing, ?Model, ?State, ?Degree) is nondet.
%
%   State is what the model says of the thing: holds, fails or unknown; Degree the least probability
%   that it is one.

verdict(Thing, Model, State, Degree) :-
    judged(Thing, Model, Module),
    outcome(Module, Model, Thing, outcome(State, Degree, _)).

%!  plays(?Face, ?Role, ?Thing, ?Model) is nondet.
%
%   Thing is a Model, and Face plays Role in it.

plays(Face, Role, Thing, Model) :-
    judged(Thing, Model, Module),
    standing(Module, Model, Thing, standing(holds, Parts)),
    with_code(Module, Model, Target,
              while_judging(Module, Model, Thing, roled(Module, Model, Target, Thing, Parts, Roled))),
    ( member(Role-Part, Roled) ; member(group(Role, Part), Roled) ),
    (   is_list(Part)
    ->  member(Face, Part)
    ;   Face = Part
    ),
    Face \== unseen.

%!  assignment(?Model, ?Thing, ?Parts) is nondet.
%
%   All conditions of Model hold for Thing with Parts, one face, or list of faces, for each role. Nothing
%   is remembered.

assignment(Model, Thing, Parts) :-
    judged(Thing, Model, Module),
    with_code(Module, Model, Target,
              while_judging(Module, Model, Thing,
                            findall(All, holding(Target, Model, Thing, All), Found))),
    member(Parts, Found).

holding(Target, Model, Thing, Parts) :-
    candidates(Target, Model, Thing, Candidates),
    member(Thing-Parts, Candidates),
    all_hold(Target, Model, Thing, Parts).

judged(Thing, Model, Module) :-
    fact(thing(Thing)),
    (   atom(Model)
    ->  once(model_module(Model, Module))
    ;   distinct(Model, model_module(Model, Module))
    ).
