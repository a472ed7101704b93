:- module(facetlog_fact_columns, [ add_columns/1,       % +Text
                                   add_kind/5           % +Scene, +Text, +Kind, +Start, -End
                                 ]).

/** <module> Facts that come as columns

Facts of one kind are handed over together, each argument's values as one text: names are cut apart
and floats decoded by C, which is three times as fast as reading clauses. The first line of the
text is a term

    facts(Scene, [kind(Name, Count, [Layout-Length, ...]), ...])

and the columns follow it without anything between them, each of Length characters. A Layout is

  - a: atoms, with a separator between them that none of them has;
  - f: floats as bytes (float_bytes.pl);
  - t: any atomic terms, a Prolog list.
*/

:- use_module(library(apply)).
:- use_module(library(error)).
:- use_module(facetlog_kb(schema)).
:- use_module(facetlog_kb(float_bytes)).

separator('\x1f\').     % ASCII's unit separator; SEPARATOR of kb/loading/encode.py

%!  add_columns(+Text) is det.
%
%   Adds the facts of Text to the scene that it names.
%
%   @error domain_error(fact, Fact) if the schema has no such fact, or it is not flat and ground.

add_columns(Text) :-
    once(sub_string(Text, End, 1, _, "\n")),
    sub_string(Text, 0, End, _, Line),
    term_string(facts(Scene, Kinds), Line),
    Start is End + 1,
    foldl(add_kind(Scene, Text), Kinds, Start, _).

%!  add_kind(+Scene, +Text, +Kind, +Start, -End) is det.
%
%   Adds the facts of one kind, whose columns begin at Start.

add_kind(Scene, Text, kind(Name, Count, Layouts), Start, End) :-
    foldl(values(Text, Count), Layouts, Columns, Start, End),
    length(Layouts, Arity),
    (   fact_schema(Name/Arity, _)
    ->  add_rows(Columns, Name, Scene)
    ;   heads(Columns, First, _),
        compound_name_arguments(Fact, Name, First),
        domain_error(fact, Fact)
    ).

values(Text, Count, Layout-Length, Values, Start, End) :-
    sub_string(Text, Start, Length, _, Column),
    decoded(Layout, Count, Column, Values),
    End is Start + Length.

decoded(a, _, Column, Names) :-
    separator(Separator),
    atomic_list_concat(Names, Separator, Column).
decoded(f, Count, Column, Floats) :-
    bytes_floats(Count, Column, Floats).
decoded(t, _, Column, Values) :-
    term_string(Values, Column),
    must_be(list(atomic), Values).

%   A predicate for each number of arguments, up to that of most facts, saves a third of the time.
add_rows([As], Name, Scene) :- !, add1(As, Name, Scene).
add_rows([As, Bs], Name, Scene) :- !, add2(As, Bs, Name, Scene).
add_rows([As, Bs, Cs], Name, Scene) :- !, add3(As, Bs, Cs, Name, Scene).
add_rows([As, Bs, Cs, Ds], Name, Scene) :- !, add4(As, Bs, Cs, Ds, Name, Scene).
add_rows(Columns, Name, Scene) :- add_any(Columns, Name, Scene).

add1([], _, _).
add1([A|As], Name, Scene) :-
    compound_name_arguments(Fact, Name, [A]),
    assertz(Scene:Fact),
    add1(As, Name, Scene).

add2([], [], _, _).
add2([A|As], [B|Bs], Name, Scene) :-
    compound_name_arguments(Fact, Name, [A, B]),
    assertz(Scene:Fact),
    add2(As, Bs, Name, Scene).

add3([], [], [], _, _).
add3([A|As], [B|Bs], [C|Cs], Name, Scene) :-
    compound_name_arguments(Fact, Name, [A, B, C]),
    assertz(Scene:Fact),
    add3(As, Bs, Cs, Name, Scene).

add4([], [], [], [], _, _).
add4([A|As], [B|Bs], [C|Cs], [D|Ds], Name, Scene) :-
    compound_name_arguments(Fact, Name, [A, B, C, D]),
    assertz(Scene:Fact),
    add4(As, Bs, Cs, Ds, Name, Scene).

add_any(Columns, Name, Scene) :-
    (   heads(Columns, Row, Rest)
    ->  compound_name_arguments(Fact, Name, Row),
        assertz(Scene:Fact),
        add_any(Rest, Name, Scene)
    ;   true
    ).

%   Fails when the columns have come to their ends.
heads([], [], []).
heads([[X|Xs]|Columns], [X|Row], [Xs|Rest]) :-
    heads(Columns, Row, Rest).
