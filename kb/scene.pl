:- module(facetlog_scene, [ new_scene/1,      % -Scene
                            add_fact/2,       % +Scene, +Fact
                            add_facts/2,      % +Scene, +Stream
                            drop_scene/1,     % +Scene
                            in_scene/2,       % +Scene, :Goal
                            fact/1            % ?Fact
                          ]).

/** <module> One Prolog module of facts for each scene

A scene is a module that holds the facts of docs/facts.md and nothing else. Rules never name it:
in_scene/2 makes it the current one while a goal runs.
*/

:- use_module(library(error)).
:- use_module(facetlog(schema)).

:- meta_predicate in_scene(+, 0).

%!  new_scene(-Scene) is det.
%
%   Scene is a fresh module that knows every fact of the schema and holds none.

new_scene(Scene) :-
    gensym('facetlog_scene:', Scene),
    set_module(Scene:class(temporary)),
    forall(fact_schema(Indicator, _), dynamic(Scene:Indicator)).

%!  add_fact(+Scene, +Fact) is det.
%
%   @error domain_error(fact, Fact) if the schema does not have it or it is not ground and flat.

add_fact(Scene, Fact) :-
    (   callable(Fact),
        functor(Fact, Name, Arity),
        fact_schema(Name/Arity, _),
        \+ ( arg(_, Fact, Arg), \+ atomic(Arg) )
    ->  assertz(Scene:Fact)
    ;   domain_error(fact, Fact)
    ).

%!  add_facts(+Scene, +Stream) is det.
%
%   Adds every term of Stream. This loop is half as slow again as the bare machine, and four times
%   as fast as a consulted file.

add_facts(Scene, Stream) :-
    repeat,
    read_term(Stream, Fact, []),
    (   Fact == end_of_file
    ->  !
    ;   add_fact(Scene, Fact),
        fail
    ).

%!  drop_scene(+Scene) is det.
%
%   Forgets the scene and its module.

drop_scene(Scene) :-
    forall(fact_schema(Name/Arity, _),
           ( functor(Head, Name, Arity),
             retractall(Scene:Head) )),
    '$destroy_module'(Scene).

%!  in_scene(+Scene, :Goal) is nondet.
%
%   Goal, asked of Scene.

in_scene(Scene, Goal) :-
    b_setval(facetlog_scene, Scene),
    call(Goal).

%!  fact(?Fact) is nondet.
%
%   Fact is one of the current scene.

fact(Fact) :-
    b_getval(facetlog_scene, Scene),
    call(Scene:Fact).
