:- module(facetlog_facts_on_demand, [ prepare_facts/1,      % +Scene
                                     await_facts/2,        % +Scene, +Text
                                     drop_facts/1          % +Scene
                                   ]).

/** <module> Facts that are decoded when they are asked for

The facts of a scene of a batch come as one text (kb/loading/facts_on_demand.py): a first line

    facts(Scene, matrices(Count, Length, [Name-Arity, ...]), [kind(Name, Rows, [Layout-Length, ...]), ...])

then the Count names of the matrices in Length characters, the matrices, and the columns of the
kinds, as fact_columns.pl has them. A kind has one clause at first, which puts the facts in its place
when it is called. What is known of each two names, in either order, stays a matrix: to look it up
takes a little longer than a clause would, to make it takes next to nothing.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(library(error)).
:- use_module(facetlog_kb(fact_columns)).
:- use_module(facetlog_kb(float_bytes)).

separator('\x1f\').     % as in fact_columns.pl

%!  prepare_facts(+Scene) is det.
%
%   Scene may have matrices.

prepare_facts(Scene) :-
    dynamic(Scene:'place in matrix'/3).

%!  await_facts(+Scene, +Text) is det.

await_facts(Scene, Text) :-
    once(sub_string(Text, End, 1, _, "\n")),
    sub_string(Text, 0, End, _, Line),
    term_string(facts(Scene, Matrices, Kinds), Line),
    Start is End + 1,
    b_setval(facetlog_awaited, Text),
    add_matrices(Matrices, Scene, Text, Start, Next),
    foldl(await_kind(Scene), Kinds, Next, _).

%!  drop_facts(+Scene) is det.
%
%   What await_facts/2 left beside the facts.

drop_facts(Scene) :-
    retractall(Scene:'place in matrix'(_, _, _)).

                 /*******************************
                 *             KINDS            *
                 *******************************/

await_kind(Scene, Kind, Start, End) :-
    Kind = kind(Name, _, Layouts),
    length(Layouts, Arity),
    functor(Head, Name, Arity),
    assertz(Scene:(Head :- facetlog_facts_on_demand:arrive(Scene, Kind, Start), Head)),
    foldl(length_of, Layouts, Start, End).

length_of(_-Length, Start, End) :-
    End is Start + Length.

%   The clause that calls this is the only one there is.
arrive(Scene, Kind, Start) :-
    Kind = kind(Name, _, Layouts),
    length(Layouts, Arity),
    functor(Head, Name, Arity),
    retractall(Scene:Head),
    b_getval(facetlog_awaited, Text),
    add_kind(Scene, Text, Kind, Start, _).

                 /*******************************
                 *           MATRICES           *
                 *******************************/

add_matrices(matrices(0, _, _), _, _, Start, Start) :- !.
add_matrices(matrices(Count, Length, Kinds), Scene, Text, Start, End) :-
    sub_string(Text, Start, Length, _, Joined),
    separator(Separator),
    atomic_list_concat(Names, Separator, Joined),
    foldl(add_place(Scene, Count), Names, 1, _),
    Next is Start + Length,
    foldl(add_matrix(Scene, Text, Count), Kinds, Next, End).

%   'place in matrix'(Name, Column, Before): Before places are in the rows before its own.
add_place(Scene, Count, Name, Column, Next) :-
    Before is (Column - 1)*Count,
    assertz(Scene:'place in matrix'(Name, Column, Before)),
    Next is Column + 1.

add_matrix(Scene, Text, Count, Name-Arity, Start, End) :-
    Places is Count*Count,
    Values is (Arity - 2)*Places,
    Length is 9*Values,
    sub_string(Text, Start, Length, _, Bytes),
    bytes_compound(Values, Bytes, Matrix),
    atom_concat('facetlog matrix ', Name, Key),
    b_setval(Key, Matrix),
    functor(Head, Name, Arity),
    Head =.. [_, A, B|Vs],
    cells(Vs, Place, 0, Places, Matrix1, Cells),
    put_compiled(Scene:(Head :-
                            'place in matrix'(A, _, Before),
                            'place in matrix'(B, Column, _),
                            A \== B,
                            Place is Before + Column,
                            b_getval(Key, Matrix1),
                            Cells)),
    End is Start + Length.

cells([V], Place, After, _, Matrix, Cell) :-
    !,
    cell(V, Place, After, Matrix, Cell).
cells([V|Vs], Place, After, Places, Matrix, ( Cell, Cells )) :-
    cell(V, Place, After, Matrix, Cell),
    Next is After + Places,
    cells(Vs, Place, Next, Places, Matrix, Cells).

cell(V, Place, 0, Matrix, arg(Place, Matrix, V)) :- !.
cell(V, Place, After, Matrix, ( Number is Place + After, arg(Number, Matrix, V) )).

%   With its arithmetic compiled.
put_compiled(Clause) :-
    current_prolog_flag(optimise, Before),
    setup_call_cleanup(
        set_prolog_flag(optimise, true),
        assertz(Clause),
        set_prolog_flag(optimise, Before)).
