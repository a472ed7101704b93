:- module(facetlog_bounded_numbers, [ bounded_value/2,     % +Expression, -Value
                                      bounded_values/2,    % +Expressions, -Values
                                      growth/2             % +Expression, -Factor
                                    ]).

/** <module> Arithmetic that cannot run away

Prolog's integers grow without bound and outside the stacks' limits, and one multiplication of long
ones cannot be interrupted. So every number that an expression starts from is short, and the
expression makes it longer by a known factor at most.
*/

:- use_module(library(apply)).
:- use_module(library(error)).
:- use_module(library(lists)).
:- use_module(facetlog_kb(white_list)).

%   Two numbers of this length are multiplied in 0.1 ms, and some 20,000 digits are more than any
%   geometry needs.
bits(65_536).

%!  bounded_value(+Expression, -Value) is det.
%
%   Value is the value of an expression that was not known when the rule or question was read.
%
%   @error resource_error(number_length) if a number in it is too long.

bounded_value(X, Value) :-
    float(X),
    !,
    Value = X.
bounded_value(X, Value) :-
    integer(X),
    !,
    check_length(X),
    Value = X.
bounded_value(X, Value) :-
    rational(X, Numerator, Denominator),
    !,
    check_length(Numerator),
    check_length(Denominator),
    Value = X.
bounded_value(X, _) :-
    var(X),
    !,
    instantiation_error(X).
bounded_value(X, Value) :-
    atom(X),
    arithmetic(X/0),
    !,
    Value is X.
bounded_value(X, Value) :-
    compound(X),
    compound_name_arguments(X, Name, Args),
    length(Args, Arity),
    arithmetic(Name/Arity),
    !,
    bounded_values(Args, Values),
    compound_name_arguments(Flat, Name, Values),
    ( long(Flat, Base, Exponent) -> must_fit(Flat, Base, Exponent) ; true ),
    value(Flat, Value0),
    bounded_value(Value0, Value).
bounded_value(X, _) :-
    type_error(evaluable, X).

%   SWI-Prolog 9.0 lacks two of the functions that later ones have.
value(log2(X), Value) :- !, Value is log(X) / log(2).
value(log(Base, X), Value) :- !, Value is log(X) / log(Base).
value(Flat, Value) :- Value is Flat.

%!  bounded_values(+Expressions, -Values) is det.

bounded_values([], []).
bounded_values([X|Xs], [Value|Values]) :-
    bounded_value(X, Value),
    bounded_values(Xs, Values).

check_length(X) :-
    X >= -0x4000000000000000,
    X =< 0x3fffffffffffffff,
    !.
check_length(X) :-
    (   short(X)
    ->  true
    ;   resource_error(number_length)
    ).

short(X) :-
    bits(Most),
    msb(max(1, abs(X))) =< Most.

long(A ** B, A, B).
long(A ^ B, A, B).
long(A << B, A, B).
long(A >> B, A, C) :- integer(B), B < 0, C is -B.

%   Base to the power of Exponent, or shifted by it, is not too long.
must_fit(Flat, Base, Exponent) :-
    (   ( float(Base) ; float(Exponent) )
    ->  true
    ;   rational(Base, Numerator, Denominator),
        rational(Exponent),
        Length is abs(Exponent) * (1 + msb(max(1, max(abs(Numerator), Denominator)))),
        bits(Most),
        Length > Most,
        \+ ( memberchk(Flat, [_**_, _^_]),
             memberchk(Base, [0, 1, -1]) )
    ->  resource_error(number_length)
    ;   true
    ).

%!  growth(+Expression, -Factor) is semidet.
%
%   Values of Expression are at most Factor times as long as the longest number that it starts from.
%   Fails if that is not known beforehand.

growth(X, 1) :-
    ( var(X) ; atom(X) ; float(X) ),
    !.
growth(X, Factor) :-
    rational(X, Numerator, Denominator),
    !,
    short(Numerator),                   % one that is given with a question may be long
    short(Denominator),
    Factor = 1.
growth(A ** B, Factor) :- !, power_growth(A, B, Factor).
growth(A ^ B, Factor) :- !, power_growth(A, B, Factor).
growth(_ << _, _) :- !, fail.
growth(_ >> _, _) :- !, fail.
growth(log2(_), _) :- !, fail.          % bounded_value/2 has them: value/2
growth(log(_, _), _) :- !, fail.
growth(X, Factor) :-
    compound_name_arguments(X, _, Args),
    maplist(growth, Args, Factors),
    sum_list(Factors, Factor).              % also of sums: fractions get a common denominator

power_growth(A, B, Factor) :-
    integer(B),
    growth(A, Base),
    Factor is max(1, abs(B)) * Base.
