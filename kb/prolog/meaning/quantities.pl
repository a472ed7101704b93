:- module(facetlog_quantities, [ value/3,          % +Expression, +Module, -Quantity
                                 value/4,          % +Expression, +Module, +Reading, -Quantity
                                 hangs_on_space/2, % +Test, -Measures
                                 any_open/1,       % +Measures
                                 variance/2,       % +Sd, -Variance
                                 comparable/3,     % +Test, +Quantity, +Quantity
                                 first_unknown/4,  % +Expressions, +Module, +Reading, -Missing
                                 longest_first_in/3, % +Module, +Measures, -Sorted
                                 measure_in/5,     % +Module, ?Measure, -Value, -Sd, -Kind
                                 crisp/0
                               ]).

/** <module> Expressions of measures into quantities

A quantity is quantity(Value, Variance, Kind): a value in its unit, the variance of it, and what it
is: number, deg, ratio, count, length, area or power(Dimension).

A Reading says what space that was not seen is taken for: `free`, or `full`, or, where values are wanted
as they are stated, `stated`. Of measures on which that has no bearing all three are the same.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(library(error)).
:- use_module(library(pairs)).
:- use_module(library(terms)).
:- use_module(library(rbtrees), []).    % which term_factorized/3 else loads in the midst of a question
:- use_module(facetlog_kb(static)).
:- use_module(facetlog_kb(bounded_numbers)).
:- use_module(facetlog(vocabulary)).
:- use_module(facetlog(measures)).

% Arithmetic is most of the work: compiled, it takes half the time. The flag ends with the file.
:- set_prolog_flag(optimise, true).

%!  crisp is semidet.
%
%   The current knowledge base takes all measured values as exact.

crisp :-
    nb_current(facetlog_crisp, true).

%!  variance(+Sd, -Variance) is det.

variance(Sd, Variance) :-
    (   crisp
    ->  Variance = 0
    ;   Variance is Sd*Sd
    ).

%!  value(+Expression, +Module, -Quantity) is semidet.
%!  value(+Expression, +Module, +Reading, -Quantity) is semidet.
%
%   Quantity is quantity(Value, Variance, Kind), variances to first order and as if the terms were
%   independent. Fails if a measure is unknown.
%
%   @error existence_error(tolerance, Name) if nobody defines it.

value(Expression, Module, Quantity) :-
    value(Expression, Module, stated, Quantity).

value(Expression, Module, Reading, quantity(V, Var, Kind)) :-
    static(expression(Expression, Module, Sort)),
    value_of(Sort, Expression, Module, Reading, V, Var, Kind).

value_of(number(X), _, _, _, X, 0, number).
value_of(negative(A), _, Module, Reading, V, Var, Kind) :-
    value(A, Module, Reading, quantity(X, Var, Kind)),
    V is -X.
value_of(A + B, _, Module, Reading, V, Var, Kind) :-
    two_alike(A, B, A + B, Module, Reading, X, Y, Var, Kind),
    V is X + Y.
value_of(A - B, _, Module, Reading, V, Var, Kind) :-
    two_alike(A, B, A - B, Module, Reading, X, Y, Var, Kind),
    V is X - Y.
value_of(A * B, _, Module, Reading, V, Var, Kind) :-
    value(A, Module, Reading, quantity(X, SX, KX)),
    value(B, Module, Reading, quantity(Y, SY, KY)),
    product(X, Y, V),
    Var is Y*Y*SX + X*X*SY,
    static(product_kind(KX, KY, Kind)).
value_of(A / B, _, Module, Reading, V, Var, Kind) :-
    value(A, Module, Reading, quantity(X, SX, KX)),
    value(B, Module, Reading, quantity(Y, SY, KY)),
    Y =\= 0,
    V is X / Y,
    Var is (SX + V*V*SY) / (Y*Y),
    static(quotient_kind(KX, KY, Kind)).
value_of(lowest(List), Test, Module, Reading, V, Var, Kind) :-
    quantities(Test, List, Module, Reading, Kind, Values),
    min_member(V-Var, Values).
value_of(highest(List), Test, Module, Reading, V, Var, Kind) :-
    quantities(Test, List, Module, Reading, Kind, Values),
    max_member(V-Var, Values).
value_of(sum(List), Test, Module, Reading, V, Var, Kind) :-
    quantities(Test, List, Module, Reading, Kind, Values),
    total(Values, V, Var).
value_of(mean(List), Test, Module, Reading, V, Var, Kind) :-
    quantities(Test, List, Module, Reading, Kind, Values),
    total(Values, Sum, SumVar),
    length(Values, Count),
    V is Sum/Count,
    Var is SumVar/(Count*Count).
value_of(smallest_step(List), Test, Module, Reading, V, Var, Kind) :-
    steps(Test, List, Module, Reading, Kind, Steps),
    min_member(V-Var, Steps).
value_of(largest_step(List), Test, Module, Reading, V, Var, Kind) :-
    steps(Test, List, Module, Reading, Kind, Steps),
    max_member(V-Var, Steps).
value_of(measure, Measure, _, Reading, V, Var, Kind) :-
    first_measure(Measure, V0, Sd, Kind),
    read_as(Reading, Measure, V0, V),
    variance(Sd, Var).
value_of(own_measure, Measure, Module, _, V, Var, Kind) :-
    (   measure(Measure, V0, Sd0, Kind0)
    ->  V = V0, Sd = Sd0, Kind = Kind0
    ;   own_measure(Module, Measure, V, Sd, Kind)
    ),
    variance(Sd, Var).

%   The differences of neighbours among the values in their order; none of fewer than two.
steps(Test, List, Module, Reading, Kind, Steps) :-
    quantities(Test, List, Module, Reading, Kind, Values),
    msort(Values, Sorted),
    findall(V-Var,
            ( append(_, [A-VarA, B-VarB|_], Sorted),
              V is B - A,
              Var is VarA + VarB ),
            Steps).

%   Sort of an Expression.
expression(Expression, Module, Sort) :-
    (   number(Expression)
    ->  finite_limit(Expression, X),
        Sort = number(X)
    ;   callable(Expression),
        operation(Expression, Module, Sort0)
    ->  Sort = Sort0
    ;   callable(Expression),
        (   defines(Module, Expression)
        ->  Sort = own_measure
        ;   Sort = measure
        )
    ).

%   Module may have a measure of that form.
defines(Module, Measure) :-
    current_predicate(Module:measured/4),
    clause(Module:measured(Measure, _, _, _), _),
    !.

operation(tolerance(Name), Module, number(X)) :-
    (   named_tolerance(Name, Module, X0)
    ->  must_be(number, X0),            % no expression that a clause made
        finite_limit(X0, X)
    ;   existence_error(tolerance, Name)
    ).
operation(-A, _, negative(A)).
operation(A + B, _, A + B).
operation(A - B, _, A - B).
operation(A * B, _, A * B).
operation(A / B, _, A / B).
operation(lowest(List), _, lowest(List)).
operation(highest(List), _, highest(List)).
operation(sum(List), _, sum(List)).
operation(mean(List), _, mean(List)).
operation(smallest_step(List), _, smallest_step(List)).
operation(largest_step(List), _, largest_step(List)).

%   A limit that is infinite is one that no measured value reaches: arithmetic refuses the other.
finite_limit(X0, X) :-
    (   abs(X0) < inf
    ->  X = X0
    ;   X is copysign(1.0e100, X0)
    ).

first_measure(Measure, V, Sd, Kind) :-
    measure(Measure, V, Sd, Kind),
    !.

%   read_as(Reading, Measure, V0, V)
read_as(stated, _, V, V).
read_as(free, Measure, V0, V) :-
    (   static(hidden_part(Measure, Fact, V1, _)),
        call(measures:fact(Fact))
    ->  V = V1
    ;   V = V0
    ).
read_as(full, Measure, V0, V) :-
    (   static(hidden_part(Measure, Fact, _, V1)),
        call(measures:fact(Fact))
    ->  V = V1
    ;   V = V0
    ).

%!  hangs_on_space(+Test, -Measures) is det.
%
%   Measures are those in Test that space may change which was not seen. In a long Test a term that
%   stands there more than once is looked at once: a clause may square a measure forty times. To find
%   such terms takes ten times as long as to look at the few of a line that somebody wrote.

hangs_on_space(Test, Measures) :-
    few_terms(Few),
    (   on_space([Test], Few, _, Measures, [])
    ->  true
    ;   term_factorized(Test, Skeleton, Shared),
        current_prolog_flag(max_tagged_integer, All),
        on_space([Skeleton|Shared], All, _, Measures, [])
    ).

few_terms(100).

%   Fails if there are more compound terms than Most, of which Left are left.
on_space([], Left, Left, Measures, Measures).
on_space([Term|Terms], Most, Left, Measures, Rest) :-
    (   compound(Term)
    ->  Most > 0,
        Most1 is Most - 1,
        compound_name_arguments(Term, _, Args),
        (   Args = [_],                 % a measure of more than one has no such part
            hidden_part(Term, _, _, _)
        ->  Measures = [Term|Measures1],
            on_space(Terms, Most1, Left, Measures1, Rest)
        ;   on_space(Args, Most1, Most2, Measures, Measures1),
            on_space(Terms, Most2, Left, Measures1, Rest)
        )
    ;   on_space(Terms, Most, Left, Measures, Rest)
    ).

%!  any_open(+Measures) is semidet.
%
%   Space that was not seen changes one of Measures, of those that hangs_on_space/2 names.

any_open([Measure|Measures]) :-
    (   static(hidden_part(Measure, Fact, _, _)),
        call(measures:fact(Fact))
    ->  true
    ;   any_open(Measures)
    ).

%   What a clause worked out may be an integer of any length.
product(X, Y, Product) :-
    (   ( float(X) ; float(Y) )
    ->  Product is X*Y
    ;   bounded_value(X*Y, Product)
    ).

two_alike(A, B, Test, Module, Reading, X, Y, Var, Kind) :-
    value(A, Module, Reading, QX),
    value(B, Module, Reading, QY),
    QX = quantity(X, SX, Kind),
    QY = quantity(Y, SY, _),
    comparable(Test, QX, QY),
    Var is SX + SY.

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
    (   catch(Float is float(Number), error(evaluation_error(_), _), fail)
    ->  true
    ;   domain_error(finite_number, Number)
    ).

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
quantities(Test, List, Module, Reading, Kind, [V-S|Values]) :-
    is_list(List),
    List = [First|Rest],
    value(First, Module, Reading, Quantity),
    Quantity = quantity(V, S, Kind),
    values(Rest, Module, Reading, Test, Quantity, Values).

values([], _, _, _, _, []).
values([Expression|Expressions], Module, Reading, Test, Quantity0, [V-S|Values]) :-
    value(Expression, Module, Reading, Quantity),
    comparable(Test, Quantity0, Quantity),
    Quantity = quantity(V, S, _),
    values(Expressions, Module, Reading, Test, Quantity0, Values).

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
    (   static(alike(Kind, LimitKind))
    ->  true
    ;   Limit =:= 0
    ->  true
    ;   type_error(comparable, Test)
    ).

alike(Kind, LimitKind) :-
    (   Kind == LimitKind
    ->  true
    ;   dimension(Kind, D),
        dimension(LimitKind, LimitD),
        D =:= LimitD
    ).

%   Power of length of a kind: what comes of it must not be known before.
dimension(length, 1) :- !.
dimension(area, 2) :- !.
dimension(power(D), D) :- !.
dimension(_, 0).

kind(0, ratio) :- !.
kind(1, length) :- !.
kind(2, area) :- !.
kind(D, power(D)).

product_kind(KX, KY, Kind) :-
    dimension(KX, DX),
    dimension(KY, DY),
    D is DX + DY,
    kind(D, Kind).

quotient_kind(KX, KY, Kind) :-
    dimension(KX, DX),
    dimension(KY, DY),
    D is DX - DY,
    kind(D, Kind).

%!  first_unknown(+Expressions, +Module, +Reading, -Missing) is semidet.
%
%   Missing is the first measure in Expressions that the scene does not know.

first_unknown(Expressions, Module, Reading, Missing) :-
    member(Expression, Expressions),
    unknown_in(Expression, Module, Reading, Missing),
    !.

unknown_in(Expression, Module, Reading, Missing) :-
    \+ value(Expression, Module, Reading, _),
    (   operands(Expression, Operands),
        member(Operand, Operands),
        unknown_in(Operand, Module, Reading, Missing0)
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
operands(smallest_step(List), List) :- is_list(List).
operands(largest_step(List), List) :- is_list(List).
