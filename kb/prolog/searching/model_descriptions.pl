:- module(facetlog_model_descriptions,
          [ roled/6,                    % +Module, +Model, +Groups, +Thing, +Parts, -Roled
            written/5,                  % +Module, +Model, +Label, -Place, -Text
            general_models/3            % +Module, +Model, -General
          ]).

/** <module> How files describe their models, beside what is judged

All of it is optional, and looked up only when a verdict is explained.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(library(pairs)).
:- use_module(library(error)).
:- use_module(facetlog_kb(named_models)).

%!  roled(+Module, +Model, +Groups, +Thing, +Parts, -Roled) is det.
%
%   Roled has Role-Part for each of Parts, then group(Role, Members) for each set that group/5 of the module
%   Groups names: names without doubles, in the order given. Of one role the first answer counts.
%
%   @error type_error if the members are no list of names, or of lists of names.

roled(Module, Model, Groups, Thing, Parts, Roled) :-
    once(Module:model(Model, _, Roles)),
    pairs_keys_values(Singles, Roles, Parts),
    (   current_predicate(Groups:group/5)
    ->  findall(Role-Members, Groups:group(Model, Thing, Parts, Role, Members), Found),
        distinct_roles(Found, [], Sets),
        append(Singles, Sets, Roled)
    ;   Roled = Singles
    ).

distinct_roles([], _, []).
distinct_roles([Role-_|Found], Known, Groups) :-
    memberchk(Role, Known),
    !,
    distinct_roles(Found, Known, Groups).
distinct_roles([Role-Members0|Found], Known, [group(Role, Members)|Groups]) :-
    must_be(atom, Role),
    must_be(list, Members0),
    flatten(Members0, Names0),
    exclude(==(unseen), Names0, Names),
    must_be(list(atom), Names),
    list_to_set(Names, Members),
    distinct_roles(Found, [Role|Known], Groups).

%!  written(+Module, +Model, +Label, -Place, -Text) is det.
%
%   What the author of a condition wrote, and where; both '' if the file does not say.
%
%   @error type_error(text, What) if it is no text.

written(Module, Model, Label, Place, Text) :-
    (   current_predicate(Module:written/4),
        Module:written(Model, Label, Place0, Text0)
    ->  must_be_text(Place0),
        must_be_text(Text0),
        Place = Place0,
        Text = Text0
    ;   Place = '',
        Text = ''
    ).

must_be_text(Text) :-
    (   ( atom(Text) ; string(Text) )
    ->  true
    ;   type_error(text, Text)
    ).

%!  general_models(+Module, +Model, -General) is det.
%
%   General lists the models that specialises/2 says Model is, those that they are and so on, the
%   nearest first. A model that is not loaded ends the way.

general_models(Module, Model, General) :-
    (   current_predicate(Module:specialises/2)
    ->  further([Model-Module], [Model], General)
    ;   General = []
    ).

further([], _, []).
further([Model-Module|Models], Known, General) :-
    findall(Other, directly(Module, Model, Other), Others0),
    list_to_set(Others0, Others1),
    subtract(Others1, Known, Others),
    findall(Other-Its,
            ( member(Other, Others), module_of(Other, Its) ),
            Next),
    append(Models, Next, Queue),
    append(Known, Others, Known1),
    append(Others, General1, General),
    further(Queue, Known1, General1).

directly(Module, Model, Other) :-
    current_predicate(Module:specialises/2),
    Module:specialises(Model, Other),
    must_be(atom, Other).

%   Outside of a knowledge base only the file's own models are known.
module_of(Model, Module) :-
    nb_current(facetlog_base, _),
    model_module(Model, Module),
    !.
