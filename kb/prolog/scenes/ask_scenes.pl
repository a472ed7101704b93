:- module(facetlog_ask_scenes, [ answers/8        % +Fewest, +Base, +Scenes, +Most, +Bindings, +Text, -Head, -Chunk
                               ]).

/** <module> Questions about scenes: checked once, then planned for arrays or answered scene by scene
*/

:- use_module(library(apply)).
:- use_module(library(lists)).
:- use_module(facetlog_kb(schema)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog_kb(question)).
:- use_module(facetlog_kb(array_plan)).
:- use_module(facetlog_kb(answers)).

%!  answers(+Fewest, +Base, +Scenes, +Most, +Bindings, +Text, -Head, -Chunk) is nondet.
%
%   Answers to the question Text about Scenes of Base, Most at the most, with Bindings of its variables.
%   Head are the names of the columns of each Chunk. Where arrays can find the answers, and there are
%   at least Fewest facts to look at, there is first plan(Names, Scenes, Plan) (array_plan.pl). The
%   chunks come after it, for whoever cannot follow it. Of its scenes it has
%   scene(Name, Scene, Generations), by which one sees when each fact of the plan was last changed.

answers(Fewest, Base, Scenes, Most, Bindings, Text, Head, Chunk) :-
    question(Text, Bindings, question(Goal, Names0, Vars, PerScene, Checked)),
    (   PerScene == true
    ->  findall(Queried, queried_scene(Base, Scenes, Queried), All),
        scene_column(All, Names0, Names),
        (   planned(Fewest, All, Checked, Vars, Dated, Plan),
            Head = plan(Names, Dated, Plan),
            Chunk = []
        ;   Head = Names,
            per_scene(All, Goal, Vars, Row, Run),
            chunk(Row, Run, Most, Chunk)
        )
    ;   nb_setval(facetlog_scene, none),
        Head = Names0,
        chunk(Vars, facetlog_query:Goal, Most, Chunk)
    ).

scene_column([_], Names, Names) :- !.
scene_column(_, Names, _) :-
    memberchk('Scene', Names),
    !,
    throw(question_error(0, 0, "Scene is the name of the first column when several scenes are asked: call this variable something else", [])).
scene_column(_, Names, ['Scene'|Names]).

planned(Fewest, All, checked(Goal, Scope), Vars, Dated, Plan) :-
    integer(Fewest),
    findall(Indicator, fact_schema(Indicator, _), Every),
    mostly_large(All, Every, Fewest),   % sooner seen than a plan is made
    array_plan(Goal, Vars, Scope, Plan),
    !,
    Plan = plan(_, _, Facts),
    mostly_large(All, Facts, Fewest),
    maplist(dated(Facts), All, Dated).

dated(Facts, Name-Scene, scene(Name, Scene, Generations)) :-
    maplist(last_changed(Scene), Facts, Generations).

%   Most scenes have a fact that is there so often. Of few facts Prolog is as fast.
mostly_large(All, Facts, Fewest) :-
    partition(large(Facts, Fewest), All, Large, Small),
    length(Large, Count),
    length(Small, Rest),
    Count > Rest.

large(_, 0, _) :- !.
large(Facts, Fewest, _-Scene) :-
    member(Name/Arity, Facts),
    functor(Head, Name, Arity),
    nth_clause(Scene:Head, Fewest, _),
    !.

%   To count the clauses would take as long as to visit them.
last_changed(Scene, Name/Arity, Generation) :-
    functor(Head, Name, Arity),
    (   predicate_property(Scene:Head, last_modified_generation(Generation0))
    ->  Generation = Generation0
    ;   Generation = 0
    ).

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
