:- module(facetlog_named_models, [ name_models/3,          % +Base, +Models, +Module
                                   unname_models/2,        % +Base, +Module
                                   model_module/2,         % ?Model, -Module
                                   unknown_model/2         % +Model, -Hint
                                 ]).

/** <module> Which models a knowledge base has, and which module defines each */

:- use_module(library(lists)).
:- use_module(facetlog_kb(recall)).
:- use_module(facetlog_kb(spelling)).

%!  name_models(+Base, +Models, +Module) is det.
%
%   The knowledge base Base has the Models that Module defines; they hide those named before.

:- dynamic base_model/3.                % Base, Model, Module

name_models(Base, Models, Module) :-
    forall(member(Model, Models), asserta(base_model(Base, Model, Module))),
    forget_all.

%!  unname_models(+Base, +Module) is det.

unname_models(Base, Module) :-
    retractall(base_model(Base, _, Module)),
    forget_all.

%!  model_module(?Model, -Module) is nondet.
%
%   Module defines Model in the current knowledge base, the last loaded first: that one
%   counts.

model_module(Model, Module) :-
    nb_current(facetlog_base, Base-_),
    base_model(Base, Model, Module).

%!  unknown_model(+Model, -Hint) is semidet.
%
%   The current knowledge base has no Model; Hint says which one is spelt nearly so, or which there
%   are.

unknown_model(Model, Hint) :-
    nb_current(facetlog_base, _),
    \+ model_module(Model, _),
    findall(Known, model_module(Known, _), Names0),
    sort(Names0, Names),
    (   nearest(Model, Names, Nearest)
    ->  format(string(Hint), "; did you mean ~q?", [Nearest])
    ;   atomic_list_concat(Names, ', ', Listed),
        format(string(Hint), "; there are ~w", [Listed])
    ).
