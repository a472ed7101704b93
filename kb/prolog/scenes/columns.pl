:- module(facetlog_columns, [ columns/3         % +Width, +Rows, -Pieces
                            ]).

/** <module> Rows of terms as columns of bytes

The first piece says how many rows there are and how each column is written, "3 fa": three rows, a
column of floats and one of atoms. Then follows one piece for each column, by its letter:

  - f: floats as bytes (float_bytes.pl), at the end of the piece;
  - n: integers of 64 bits and finite floats, in decimals, with commas between them;
  - a: atoms; s: strings; with a separator that occurs in none of them;
  - j: any terms: a list as json.pl writes it.
*/

:- use_module(library(apply)).
:- use_module(library(lists)).
:- use_module(library(error)).
:- use_module(facetlog_kb(float_bytes)).
:- use_module(facetlog_kb(json)).

%!  columns(+Width, +Rows, -Pieces) is det.
%
%   Rows are terms row(...) of Width arguments, whose variables are bound on the way: a variable
%   that occurs twice in a row has the same name in all columns.
%
%   @error domain_error(acyclic_term, _) if there is a cyclic term among them.

columns(Width, Rows, [Header|Pieces]) :-
    length(Rows, Count),
    transposed(Width, Rows, Columns),
    (   ground(Columns)
    ->  true
    ;   maplist(name_variables, Rows)
    ),
    pieces(Columns, Letters, Pieces),
    atomic_list_concat([Count, ' '|Letters], Header0),
    atom_string(Header0, Header).

pieces([], [], []).
pieces([Column|Columns], [Letter|Letters], [Piece|Pieces]) :-
    piece(Column, Letter, Piece),
    pieces(Columns, Letters, Pieces).

%   The first value says what may become of the column; the others are compared with it.
piece(Column, Letter, Piece) :-
    (   Column = [First|_],
        piece_like(First, Column, Letter, Piece)
    ->  true
    ;   Letter = j,
        json(Column, Piece)
    ).

piece_like(First, Column, f, Piece) :-
    float(First),
    floats(Column),
    floats_bytes(Column, Piece).
piece_like(First, Column, n, Piece) :-
    number(First),
    plain_numbers(Column),
    joined(Column, ',', Piece).
piece_like(First, Column, a, Piece) :-
    atom(First),
    atoms(Column),
    separated(Column, Piece).
piece_like(First, Column, s, Piece) :-
    string(First),
    strings(Column),
    separated(Column, Piece).

floats([]).
floats([X|Xs]) :- float(X), floats(Xs).

plain_numbers([]).
plain_numbers([X|Xs]) :- plain_number(X), plain_numbers(Xs).

plain_number(X) :- integer(X), !, X >= -0x8000000000000000, X =< 0x7fffffffffffffff.
plain_number(X) :- float(X), X < inf, X > -inf.    % neither holds of not-a-number

%   The empty list is not the atom '[]', but has its text.
atoms([]).
atoms([X|Xs]) :- atom(X), X \== [], atoms(Xs).

strings([]).
strings([X|Xs]) :- string(X), strings(Xs).

separator("\x1f\").     % ASCII's unit separator

separated(Texts, Piece) :-
    separator(Separator),
    atomics_to_string(Texts, All),
    split_string(All, Separator, "", [_]),
    joined(Texts, Separator, Piece).

joined(Texts, Separator, Piece) :-
    atomic_list_concat(Texts, Separator, Atom),
    atom_string(Atom, Piece).

                 /*******************************
                 *         TRANSPOSING          *
                 *******************************/

%   Up to four columns are taken out at one go, wider rows column by column: a predicate for each
%   width is four times as fast as one for all.
transposed(0, _, []) :- !.
transposed(1, Rows, [As]) :- !, transposed1(Rows, As).
transposed(2, Rows, [As, Bs]) :- !, transposed2(Rows, As, Bs).
transposed(3, Rows, [As, Bs, Cs]) :- !, transposed3(Rows, As, Bs, Cs).
transposed(4, Rows, [As, Bs, Cs, Ds]) :- !, transposed4(Rows, As, Bs, Cs, Ds).
transposed(Width, Rows, Columns) :-
    numlist(1, Width, Numbers),
    maplist(column(Rows), Numbers, Columns).

transposed1([], []).
transposed1([row(A)|Rows], [A|As]) :- transposed1(Rows, As).

transposed2([], [], []).
transposed2([row(A, B)|Rows], [A|As], [B|Bs]) :- transposed2(Rows, As, Bs).

transposed3([], [], [], []).
transposed3([row(A, B, C)|Rows], [A|As], [B|Bs], [C|Cs]) :- transposed3(Rows, As, Bs, Cs).

transposed4([], [], [], [], []).
transposed4([row(A, B, C, D)|Rows], [A|As], [B|Bs], [C|Cs], [D|Ds]) :-
    transposed4(Rows, As, Bs, Cs, Ds).

column([], _, []).
column([Row|Rows], Number, [X|Xs]) :-
    arg(Number, Row, X),
    column(Rows, Number, Xs).
