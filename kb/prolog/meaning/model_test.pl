:- module(facetlog_model_test, [ model_outcome/3,     % +Thing, +Model, -Outcome
                                model_state/3,       % +Thing, +Model, -State
                                part_in/4            % +Thing, +Model, +Role, -Part
                              ]).

/** <module> What another model says, as a test

The verdict of any model of the current knowledge base, on any thing of the current scene. A
model that is being judged for that thing at the moment says nothing yet.
*/

:- use_module(library(error)).
:- use_module(library(lists)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog_kb(named_models)).
:- use_module(facetlog_kb(judge)).
:- use_module(facetlog_kb(in_progress)).

%!  model_outcome(+Thing, +Model, -Outcome) is det.
%
%   Outcome is outcome(State, Low, High, Cause). Cause is none, or why nothing is known: unseen,
%   unstated (the scene has no such thing) or cycle.
%
%   @error existence_error(model, Model) if no such model is loaded.

model_outcome(Thing, Model, Outcome) :-
    definition(Thing, Model, Definition),
    (   Definition = module(Module)
    ->  outcome(Module, Model, Thing, Outcome0),
        Outcome0 = outcome(State, Low, High),
        Outcome = outcome(State, Low, High, none)
    ;   Definition = nothing(Cause),
        Outcome = outcome(unknown, 0, 1, Cause)
    ).

%!  model_state(+Thing, +Model, -State) is det.
%
%   State of the Outcome, which takes no proof.
%
%   @error as model_outcome/3

model_state(Thing, Model, State) :-
    definition(Thing, Model, Definition),
    (   Definition = module(Module),
        standing(Module, Model, Thing, standing(State0, _))
    ->  State = State0
    ;   State = unknown
    ).

%!  part_in(+Thing, +Model, +Role, -Part) is det.
%
%   Part plays Role where Thing is a Model, as far as it is one: `unseen` if nothing is known to.
%
%   @error as model_outcome/3

part_in(Thing, Model, Role, Part) :-
    definition(Thing, Model, Definition),
    (   Definition = module(Module),
        standing(Module, Model, Thing, standing(State, Parts)),
        State \== fails,
        once(Module:model(Model, _, Roles)),
        nth1(Number, Roles, Role)
    ->  nth1(Number, Parts, Part)
    ;   Part = unseen
    ).

definition(Thing, Model, Definition) :-
    must_be(atom, Model),
    (   model_module(Model, Module0)
    ->  Module = Module0
    ;   existence_error(model, Model)
    ),
    (   Thing == unseen
    ->  Definition = nothing(unseen)
    ;   \+ ( atom(Thing), fact(thing(Thing)) )
    ->  Definition = nothing(unstated)
    ;   being_judged(Module, Model, Thing)
    ->  Definition = nothing(cycle)
    ;   Definition = module(Module)
    ).
