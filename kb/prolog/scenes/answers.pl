:- module(facetlog_answers, [ answers/7,        % +Base, +Scenes, +Most, +Bindings, +Text, -Head, -Chunk
                              chunk/4           % +Row, :Goal, +Most, -Chunk
                            ]).

/** <module> The solutions of a goal, in chunks

Solutions are gathered as findall/3 gathers them and handed over some thousands at a time, so that
no more of them are ever held than one chunk has. What is handed over are columns (columns.pl).
*/

:- use_module(facetlog_kb(columns)).
:- use_module(library(lists)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog_kb(question)).

:- meta_predicate chunk(+, 0, +, -).

first_size(64).         % solutions: the first answers come soon
full_size(4096).        % solutions: beyond some thousands nothing gets faster (measured)
most_seconds(0.05).     % a chunk that took as long is handed over as it is
most_unwatched(64).     % solutions between two looks at the clock, at most

%!  chunk(+Row, :Goal, +Most, -Chunk) is nondet.
%
%   Chunk is the next part of the solutions of Goal, of at most Most (which may be `inf`), as
%   columns/3 makes it of their Rows. The last one may be empty, and leaves no choice point.
%
%   What was found before an error or a limit is a chunk of its own; the error follows it. Otherwise
%   a chunk ends when it is full, or with the first solution that is found after its time. Solutions
%   are looked at by their number: that costs nothing while nothing is due.

chunk(Row, Goal, Most, Chunk) :-
    length(Row, Width),
    compound_name_arguments(Template, row, Row),
    setup_call_cleanup(
        '$new_findall_bag',
        rows(Template, Goal, Most, Rows),
        '$destroy_findall_bag'),
    columns(Width, Rows, Chunk).

%   The loop of findnsols/4 in SWI-Prolog's boot/bags.pl, with a limit and a clock. Next is the
%   number of the solution at which something may be due.
rows(Template, Goal, Most, Rows) :-
    get_time(Now),
    first_size(Size),
    End is min(Size, Most),
    State = state(1, 1, End, Now),      % Next, Stride, End, Start
    (   Most > 0,
        catch(call_cleanup(Goal, Last = true), Error, true),
        (   nonvar(Error)
        ->  '$collect_findall_bag'(Rows, []),
            (   Rows == []
            ->  throw(Error)
            ;   '$suspend_findall_bag'
            ;   throw(Error)
            )
        ;   '$add_findall_bag'(Template, Found),
            Last \== true,
            arg(1, State, Found),
            due(State, Found),
            '$collect_findall_bag'(Rows, []),
            (   Found == Most
            ->  !
            ;   '$suspend_findall_bag'
            ;   begin(State, Found, Most),
                fail
            )
        )
    ;   '$collect_findall_bag'(Rows, [])
    ).

%   Fails if the chunk goes on. The longer nothing is due, the less often the clock is read.
due(state(_, _, Found, _), Found) :- !.
due(State, Found) :-
    State = state(_, Stride0, End, Start),
    get_time(Now),
    most_seconds(Seconds),
    Now - Start < Seconds,
    !,
    most_unwatched(Most),
    Stride is min(2*Stride0, Most),
    Next is min(Found + Stride, End),
    nb_setarg(1, State, Next),
    nb_setarg(2, State, Stride),
    fail.
due(_, _).

begin(State, Found, Most) :-
    get_time(Now),
    full_size(Size),
    Next is Found + 1,
    End is min(Found + Size, Most),
    nb_setarg(1, State, Next),
    nb_setarg(2, State, 1),
    nb_setarg(3, State, End),
    nb_setarg(4, State, Now).

                 /*******************************
                 *           SCENES            *
                 *******************************/

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
