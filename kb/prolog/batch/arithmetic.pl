:- module(facetlog_arithmetic, [ arithmetic/2      % +Goal, -Code
                               ]).

/** <module> Arithmetic on what is known

What partial.pl leaves of it.
*/

:- use_module(library(apply)).

%!  arithmetic(+Goal, -Code) is semidet.
%
%   Code is what is left of Goal, an arithmetic comparison or assignment or the question whether something
%   is a number: `true` or `fail` where that is known. Fails for other goals.

arithmetic(V is Expression, Code) :-
    simple(Expression, Simple),
    (   ( number(Simple) ; var(Simple) )
    ->  ( V = Simple -> Code = true ; Code = fail )
    ;   Code = ( V is Simple )
    ).
arithmetic(float(X), Code) :-
    ( var(X) -> Code = float(X) ; float(X) -> Code = true ; Code = fail ).
arithmetic(Comparison, Code) :-
    comparison(Comparison, A0, B0, A, B, Simple),
    simple(A0, A),
    simple(B0, B),
    (   number(A),
        number(B)
    ->  ( call(Simple) -> Code = true ; Code = fail )
    ;   Code = Simple
    ).

comparison(A0 < B0, A0, B0, A, B, A < B).
comparison(A0 > B0, A0, B0, A, B, A > B).
comparison(A0 =< B0, A0, B0, A, B, A =< B).
comparison(A0 >= B0, A0, B0, A, B, A >= B).
comparison(A0 =:= B0, A0, B0, A, B, A =:= B).
comparison(A0 =\= B0, A0, B0, A, B, A =\= B).

%   What is added to nothing, or taken once, is what it was; all measured values are finite.
simple(Expression, Simple) :-
    (   compound(Expression)
    ->  Expression =.. [Name|Args0],
        maplist(simple, Args0, Args),
        Plain =.. [Name|Args],
        (   maplist(number, Args)
        ->  Simple is Plain
        ;   without(Plain, Simple0)
        ->  Simple = Simple0
        ;   Simple = Plain
        )
    ;   Simple = Expression
    ).

without(A + B, A) :- zero(B).
without(A + B, B) :- zero(A).
without(A - B, A) :- zero(B).
without(A * B, 0) :- ( zero(A) ; zero(B) ).
without(A * B, A) :- B == 1.
without(A * B, B) :- A == 1.
without(A / B, A) :- B == 1.
without(A / _, 0) :- zero(A).

zero(X) :- number(X), X =:= 0.
