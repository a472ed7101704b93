:- module(facetlog_quantities, [ value/3,          % +Expression, +Module, -Quantity
                                 variance/2,       % +Sd, -Variance
                                 comparable/3,     % +Test, +Quantity, +Quantity
                                 first_unknown/3,  % +Expressions, +Module, -Missing
                                 longest_first_in/3, % +Module, +Measures, -Sorted
                                 measure_in/5,     % +Module, ?Measure, -Value, -Sd, -Kind
                                 crisp/0
                               ]).

/** <module> Expressions of measures into quantities

A quantity is quantity(Value, Variance, Kind): a value in its unit, the variance of it, and what it
is: number, deg, ratio, count, length, area or power(Dimension).
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(library(error)).
:- use_module(library(pairs)).
:- use_module(facetlog_kb(bounded_numbers)).
:- use_module(facetlog(vocabulary)).

% Arithmetic is most of the work: compiled, it takes half the time. The flag ends with the file.
:- set_prolog_flag(optimise, true).

%!  crisp is semidet.
%
%   The knowledge base that is asked takes all measured values as exact.

crisp :-
    nb_current(facetlog_crisp, true).

%!  variance(+Sd, -Variance) is det.

variance(Sd, Variance) :-
    (   crisp
    ->  Variance = 0
    ;   Variance is Sd*Sd
    ).

%!  value(+Expression, +Module, -Quantity) is semidet.
%
%   Quantity is quantity(Value, Variance, Kind), variances to first order and as if the terms were
%   independent. Fails if a measure is unknown.

value(X, _, quantity(X, 0, number)) :-
    number(X),
    !.
value(tolerance(Name), Module, quantity(X, 0, number)) :-
    !,
    (   named_tolerance(Name, Module, X)
    ->  ( number(X) -> true ; must_be(number, X) )  % no expression that a clause made
    ;   existence_error(tolerance, Name)
    ).
value(-A, Module, quantity(V, S, Kind)) :-
    !,
    value(A, Module, quantity(X, S, Kind)),
    V is -X.
value(A + B, Module, quantity(V, S, Kind)) :-
    !,
    sum_terms(A, B, Module, X, Y, S, Kind),
    V is X + Y.
value(A - B, Module, quantity(V, S, Kind)) :-
    !,
    sum_terms(A, B, Module, X, Y, S, Kind),
    V is X - Y.
value(A * B, Module, quantity(V, S, Kind)) :-
    !,
    value(A, Module, quantity(X, SX, KX)),
    value(B, Module, quantity(Y, SY, KY)),
    product(X, Y, V),
    S is Y*Y*SX + X*X*SY,
    dimension(KX, DX),
    dimension(KY, DY),
    D is DX + DY,
    kind(D, Kind).
value(A / B, Module, quantity(V, S, Kind)) :-
    !,
    value(A, Module, quantity(X, SX, KX)),
    value(B, Module, quantity(Y, SY, KY)),
    Y =\= 0,
    V is X / Y,
    S is (SX + V*V*SY) / (Y*Y),
    dimension(KX, DX),
    dimension(KY, DY),
    D is DX - DY,
    kind(D, Kind).
value(lowest(List), Module, quantity(V, S, Kind)) :-
    !,
    quantities(lowest(List), List, Module, Kind, Values),
    min_member(V-S, Values).
value(highest(List), Module, quantity(V, S, Kind)) :-
    !,
    quantities(highest(List), List, Module, Kind, Values),
    max_member(V-S, Values).
value(sum(List), Module, quantity(V, S, Kind)) :-
    !,
    quantities(sum(List), List, Module, Kind, Values),
    total(Values, V, S).
value(mean(List), Module, quantity(V, S, Kind)) :-
    !,
    quantities(mean(List), List, Module, Kind, Values),
    total(Values, Sum, Var),
    length(Values, Count),
    V is Sum/Count,
    S is Var/(Count*Count).
value(Measure, _, quantity(V, S, Kind)) :-
    callable(Measure),
    measure(Measure, V, Sd, Kind),
    !,
    ( nb_current(facetlog_crisp, true) -> S = 0 ; S is Sd*Sd ).     % variance/2, where most is asked
value(Measure, Module, quantity(V, S, Kind)) :-
    own_measure(Module, Measure, V, Sd, Kind),
    variance(Sd, S).

%   What a clause worked out may be an integer of any length.
product(X, Y, Product) :-
    (   rational(X),
        rational(Y)
    ->  bounded_value(X*Y, Product)
    ;   Product is X*Y
    ).

sum_terms(A, B, Module, X, Y, S, Kind) :-
    value(A, Module, QX),
    value(B, Module, QY),
    QX = quantity(X, SX, Kind),
    QY = quantity(Y, SY, _),
    comparable(A + B, QX, QY),
    S is SX + SY.

%!  measure_in(+Module, ?Measure, -Value, -Sd, -Kind) is nondet.
%
%   A measure of the vocabulary, or one that Module defines.

measure_in(_, Measure, Value, Sd, Kind) :-
    measure(Measure, Value, Sd, Kind).
measure_in(Module, Measure, Value, Sd, Kind) :-
    own_measure(Module, Measure, Value, Sd, Kind).

%   The first answer counts. What a clause worked out may be anything.
own_measure(Module, Measure, Value, Sd, Kind) :-
    current_predicate(Module:measured/4),
    callable(Measure),
    Module:measured(Measure, Value0, Sd0, Kind0),
    !,
    finite(Value0, Value),
    finite(Sd0, Sd),
    ( Sd >= 0 -> true ; domain_error(standard_deviation, Sd0) ),
    must_be(oneof([deg, ratio, count, length, area]), Kind0),
    Kind = Kind0.

finite(Number, Float) :-
    must_be(number, Number),
    Float is float(Number),
    ( abs(Float) < inf -> true ; domain_error(finite_number, Number) ).

%!  longest_first_in(+Module, +Measures, -Sorted) is semidet.
%
%   As longest_first/2 of the vocabulary, with the measures that Module defines.

longest_first_in(Module, Measures, Sorted) :-
    maplist(value_in(Module), Measures, Values),
    pairs_keys_values(Pairs, Values, Measures),
    sort(1, @>=, Pairs, Descending),
    pairs_values(Descending, Sorted).

value_in(Module, Measure, Value) :-
    value(Measure, Module, quantity(Value, _, _)).

%   Values are Value-Variance of all of List, which is not empty.
quantities(Test, List, Module, Kind, [V-S|Values]) :-
    is_list(List),
    List = [First|Rest],
    value(First, Module, Quantity),
    Quantity = quantity(V, S, Kind),
    values(Rest, Module, Test, Quantity, Values).

values([], _, _, _, []).
values([Expression|Expressions], Module, Test, Quantity0, [V-S|Values]) :-
    value(Expression, Module, Quantity),
    comparable(Test, Quantity0, Quantity),
    Quantity = quantity(V, S, _),
    values(Expressions, Module, Test, Quantity0, Values).

%   Measured values are floats; what a clause worked out may be an integer of any length.
total(Values, Sum, Var) :-
    foldl(plus_value, Values, 0-0, Sum-Var).

plus_value(V-S, Sum0-Var0, Sum-Var) :-
    bounded_value(V, V1),
    Sum is Sum0 + V1,
    Var is Var0 + S.

named_tolerance(Name, Module, X) :-
    current_predicate(Module:tolerance/2),
    Module:tolerance(Name, X),
    !.
named_tolerance(Name, _, X) :-
    vocabulary:tolerance(Name, X).

%!  comparable(+Test, +Quantity, +Quantity) is det.
%
%   @error type_error(comparable, Test) if a length is compared with a bare number, or the like.

comparable(Test, quantity(_, _, Kind), quantity(Limit, _, LimitKind)) :-
    (   Kind == LimitKind
    ->  true
    ;   dimension(Kind, D),
        dimension(LimitKind, D)
    ->  true
    ;   Limit =:= 0
    ->  true
    ;   type_error(comparable, Test)
    ).

%   Power of length of a kind.
dimension(length, 1) :- !.
dimension(area, 2) :- !.
dimension(power(D), D) :- !.
dimension(_, 0).

kind(0, ratio) :- !.
kind(1, length) :- !.
kind(2, area) :- !.
kind(D, power(D)).

%!  first_unknown(+Expressions, +Module, -Missing) is semidet.
%
%   Missing is the first measure in Expressions that the scene does not know.

first_unknown(Expressions, Module, Missing) :-
    member(Expression, Expressions),
    unknown_in(Expression, Module, Missing),
    !.

unknown_in(Expression, Module, Missing) :-
    \+ value(Expression, Module, _),
    (   operands(Expression, Operands),
        member(Operand, Operands),
        unknown_in(Operand, Module, Missing0)
    ->  Missing = Missing0
    ;   Missing = Expression
    ).

operands(-A, [A]).
operands(A + B, [A, B]).
operands(A - B, [A, B]).
operands(A * B, [A, B]).
operands(A / B, [A, B]).
operands(lowest(List), List) :- is_list(List).
operands(highest(List), List) :- is_list(List).
operands(sum(List), List) :- is_list(List).
operands(mean(List), List) :- is_list(List).
