:- module(facetlog_ask_scenes, [ answers/7        % +Base, +Scenes, +Most, +Bindings, +Text, -Head, -Chunk
                               ]).

/** <module> Questions about scenes: checked once, then answered scene by scene
*/

:- use_module(library(lists)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog_kb(question)).
:- use_module(facetlog_kb(answers)).

%!  answers(+Base, +Scenes, +Most, +Bindings, +Text, -Head, -Chunk) is nondet.
%
%   Answers to the question Text about Scenes of Base, Most at the most, with Bindings of its variables.
%   Head are the names of the columns of each Chunk.

answers(Base, Scenes, Most, Bindings, Text, Head, Chunk) :-
    question(Text, Bindings, question(Goal, Names, Vars, PerScene)),
    (   PerScene == true
    ->  findall(Queried, queried_scene(Base, Scenes, Queried), All),
        scene_column(All, Names, Head),
        per_scene(All, Goal, Vars, Row, Run),
        chunk(Row, Run, Most, Chunk)
    ;   nb_setval(facetlog_scene, none),
        Head = Names,
        chunk(Vars, facetlog_query:Goal, Most, Chunk)
    ).

scene_column([_], Names, Names) :- !.
scene_column(_, Names, _) :-
    memberchk('Scene', Names),
    !,
    throw(question_error(0, 0, "Scene is the name of the first column when several scenes are asked: call this variable something else", [])).
scene_column(_, Names, ['Scene'|Names]).

per_scene([_-Scene], Goal, Vars, Vars, in_scene(Scene, facetlog_query:Direct)) :-
    !,
    direct(Goal, Scene, Direct).
per_scene(All, Goal, Vars, [Name|Vars],
          ( member(Name-Scene, All), in_scene(Scene, facetlog_query:Direct) )) :-
    direct(Goal, Scene, Direct).

%   Goals that are facts are called in the scene itself: that is twice as fast as to look for
%   the current one.
direct(Goal, _, Goal) :-
    var(Goal),
    !.
direct(fact(Fact), Scene, Scene:Fact) :- !.
direct((A , B), Scene, (C , D)) :- !, direct(A, Scene, C), direct(B, Scene, D).
direct((A ; B), Scene, (C ; D)) :- !, direct(A, Scene, C), direct(B, Scene, D).
direct((A -> B), Scene, (C -> D)) :- !, direct(A, Scene, C), direct(B, Scene, D).
direct((A *-> B), Scene, (C *-> D)) :- !, direct(A, Scene, C), direct(B, Scene, D).
direct(\+ A, Scene, \+ B) :- !, direct(A, Scene, B).
direct(Goal, _, Goal).
