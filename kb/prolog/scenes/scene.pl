:- module(facetlog_scene, [ new_scene/1,      % +Scene
                            name_scene/3,     % +Base, +Name, +Scene
                            unname_scene/2,   % +Base, +Name
                            destroy_scene/1,  % +Scene
                            queried_scene/3,    % +Base, +Names, ?Queried
                            in_scene/2,       % +Scene, :Goal
                            in/2,             % ?Name, :Goal
                            fact/1            % ?Fact
                          ]).

/** <module> One Prolog module of facts for each scene

A scene is a module that holds the facts of the schema, what was worked out from them, and
nothing else. Rules never name it: in_scene/2 makes it the current one while a goal runs. A
knowledge base gives its scenes names; one process may have several such bases.
*/

:- use_module(library(error)).
:- use_module(library(lists)).
:- use_module(facetlog_kb(schema)).

:- meta_predicate in_scene(+, 0), in(?, 0).

:- dynamic scene_module/3.              % Base, Name, Scene

%!  new_scene(+Scene) is det.
%
%   Makes the module Scene, which knows every fact of the schema and holds none.

new_scene(Scene) :-
    set_module(Scene:class(temporary)),
    forall(fact_schema(Indicator, _), dynamic(Scene:Indicator)).

%!  destroy_scene(+Scene) is det.
%
%   Forgets the module and all that is in it. Nobody may be asking it: the caller sees to that.

destroy_scene(Scene) :-
    % A predicate that never had a clause would not be freed with its module.
    forall(fact_schema(Name/Arity, _),
           ( functor(Head, Name, Arity),
             assertz(Scene:Head) )),
    forall(( current_predicate(Scene:Name/Arity),
             functor(Head, Name, Arity),
             predicate_property(Scene:Head, dynamic),
             \+ predicate_property(Scene:Head, imported_from(_)) ),
           retractall(Scene:Head)),
    '$destroy_module'(Scene).

%!  name_scene(+Base, +Name, +Scene) is det.
%
%   From now on Name is Scene, in the knowledge base Base.

name_scene(Base, Name, Scene) :-
    transaction(( retractall(scene_module(Base, Name, _)),
                  assertz(scene_module(Base, Name, Scene)) )).

%!  unname_scene(+Base, +Name) is det.
%
%   Base has no scene Name any more; its module is still there.

unname_scene(Base, Name) :-
    retractall(scene_module(Base, Name, _)).

%!  queried_scene(+Base, +Names, ?Queried) is nondet.
%
%   Queried is Name-Scene, one of those whose Names are given, or of all if Names is `all`.

queried_scene(Base, all, Name-Scene) :-
    !,
    scene_module(Base, Name, Scene).
queried_scene(Base, Names, Name-Scene) :-
    member(Name, Names),
    scene_module(Base, Name, Scene).

%!  in_scene(+Scene, :Goal) is nondet.
%
%   Goal in Scene.

in_scene(Scene, Goal) :-
    b_setval(facetlog_scene, Scene),
    call(Goal).

%!  in(?Name, :Goal) is nondet.
%
%   Goal in the scene Name; in each of the scenes of the question if Name is unbound.

in(Name, Goal) :-
    b_getval(facetlog_base, Base-Names),
    nb_current(facetlog_scene, Before),
    queried_scene(Base, Names, Name-Scene),
    in_scene(Scene, Goal),
    b_setval(facetlog_scene, Before).

%!  fact(?Fact) is nondet.
%
%   Fact is one of the current scene.

fact(Fact) :-
    b_getval(facetlog_scene, Scene),
    call(Scene:Fact).
