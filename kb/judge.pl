:- module(facetlog_judge, [ evaluate/3,       % +Test, +Module, -Proof
                            judge/4,          % +Module, +Model, +Thing, -Verdict
                            comparison/3      % ?Test, ?Measure, ?Bounds
                          ]).

/** <module> Tests into proofs, models into verdicts

A test is a term over the words of the vocabulary. Evaluating one gives

    proof(State, Low, High, Test, Detail, Children)

State is holds, fails or unknown, as the measured values say (the paper's crisp answer). Low and
High bound the probability that the *true* values lie within the tolerances, from the standard
deviations: equal where all was measured, 0 and 1 where nothing is known. Detail is

  - compared(Value, Sd, Kind, Within): Within is near(Target, Tolerance), between(Low, High),
    at_least(Limit) or at_most(Limit), all in numbers;
  - uncertain(Value, Sd, Kind, Within): the same, but the deviation is too large to tell;
  - fact(Truth): a relation, true, false or unknown;
  - missing(Measure): what the scene does not know;
  - short(Test): a word of the model or the vocabulary, which is short for Test;
  - all, any, not, expect(Weight), not_asked: what became of the children.

Probabilities of conditions are multiplied (the least error for the box's three angles, against
minimum and sum); alternatives take the greatest.
*/

:- use_module(library(lists)).
:- use_module(library(aggregate)).
:- use_module(library(apply)).
:- use_module(library(pairs)).
:- use_module(library(error)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog(vocabulary)).

                 /*******************************
                 *             TESTS            *
                 *******************************/

%!  evaluate(+Test, +Module, -Proof) is det.
%
%   Proof of Test in the current scene. Module may define words by means/2 and named tolerances by
%   tolerance/2.
%
%   @error existence_error(word, Name/Arity) if Test is not in the vocabulary.
%   @error type_error(comparable, Test) if a length is compared with a bare number, or the like.

evaluate(Test, Module, proof(State, Low, High, Test, Detail, Children)) :-
    must_be(nonvar, Test),
    (   comparison(Test, Measure, Bounds)
    ->  compare(Measure, Bounds, Module, Test, State, Low, High, Detail),
        Children = []
    ;   connective(Test, Module, How, Subtests)
    ->  evaluate_all(Subtests, Module, Children),
        combine(How, Children, State, Low, High, Detail)
    ;   relation(Test, Truth)
    ->  truth(Truth, State, Low, High),
        Detail = fact(Truth),
        Children = []
    ;   meaning(Test, Module, Meaning)
    ->  evaluate(Meaning, Module, Child),
        Child = proof(State, Low, High, _, _, _),
        Detail = short(Meaning),
        Children = [Child]
    ;   functor(Test, Name, Arity),
        existence_error(word, Name/Arity)
    ).

evaluate_all([], _, []).
evaluate_all([Test|Tests], Module, [Proof|Proofs]) :-
    evaluate(Test, Module, Proof),
    evaluate_all(Tests, Module, Proofs).

truth(true, holds, 1, 1).
truth(false, fails, 0, 0).
truth(unknown, unknown, 0, 1).

meaning(Test, Module, Meaning) :-
    current_predicate(Module:means/2),
    Module:means(Test, Meaning),
    !.
meaning(Test, _, Meaning) :-
    vocabulary:means(Test, Meaning),
    !.

                 /*******************************
                 *          CONNECTIVES         *
                 *******************************/

connective(all(Tests), _, all, Tests).
connective(any(Tests), _, any, Tests).
connective(not(Test), _, not, [Test]).
connective(if_known(Test), _, if_known, [Test]).
connective(expect(Weight, Test), _, expect(Weight), [Test]).
connective(each(X, List, Test), _, all, Tests) :-
    findall(Test, member(X, List), Tests).
connective(some(X, List, Test), _, any, Tests) :-
    findall(Test, member(X, List), Tests).
connective(each_pair(X, Y, List, Test), _, all, Tests) :-
    findall(Test, ( append(_, [X|Rest], List), member(Y, Rest) ), Tests).

combine(all, Proofs, State, Low, High, all) :-
    product(Proofs, holds, 1, 1, State, Low, High).
combine(any, Proofs, State, Low, High, any) :-
    greatest(Proofs, fails, 0, 0, State, Low, High).
combine(not, [proof(S, L, H, _, _, _)], State, Low, High, not) :-
    opposite_state(S, State),
    Low is 1 - H,
    High is 1 - L.
combine(if_known, [proof(S, L, H, _, _, _)], State, Low, High, Detail) :-
    (   S == unknown
    ->  State = holds, Low = 1, High = 1, Detail = not_asked
    ;   State = S, Low = L, High = H, Detail = all
    ).
combine(expect(Weight), [proof(_, L, H, _, _, _)], holds, Low, High, expect(Weight)) :-
    Low is 1 - Weight*(1 - L),
    High is 1 - Weight*(1 - H).

product([], S, L, H, S, L, H).
product([proof(S1, L1, H1, _, _, _)|Proofs], S0, L0, H0, S, L, H) :-
    both(S0, S1, S2),
    L2 is L0*L1,
    H2 is H0*H1,
    product(Proofs, S2, L2, H2, S, L, H).

greatest([], S, L, H, S, L, H).
greatest([proof(S1, L1, H1, _, _, _)|Proofs], S0, L0, H0, S, L, H) :-
    either(S0, S1, S2),
    L2 is max(L0, L1),
    H2 is max(H0, H1),
    greatest(Proofs, S2, L2, H2, S, L, H).

% Kleene's three values.
both(fails, _, fails) :- !.
both(_, fails, fails) :- !.
both(holds, holds, holds) :- !.
both(_, _, unknown).

either(holds, _, holds) :- !.
either(_, holds, holds) :- !.
either(fails, fails, fails) :- !.
either(_, _, unknown).

opposite_state(holds, fails).
opposite_state(fails, holds).
opposite_state(unknown, unknown).

                 /*******************************
                 *          COMPARISONS         *
                 *******************************/

comparison(near(M, Target, Tolerance), M, near(Target, Tolerance)).
comparison(between(M, Low, High), M, between(Low, High)).
comparison(at_least(M, Limit), M, at_least(Limit)).
comparison(at_most(M, Limit), M, at_most(Limit)).

compare(Measure, Bounds, Module, Test, State, Low, High, Detail) :-
    Bounds =.. [Sort|Limits],
    (   value(Measure, Module, Value),
        values(Limits, Module, Values)
    ->  maplist(comparable(Test, Value), Values),
        region(Sort, Value, Values, Margins, Within),
        mass_within(Margins, 1, Degree),
        Value = quantity(V, Var, Kind),
        Sd is sqrt(Var),
        outcome(Measure, Sort, Margins, Degree, State, Low, High),
        (   State == unknown
        ->  Detail = uncertain(V, Sd, Kind, Within)
        ;   Detail = compared(V, Sd, Kind, Within)
        )
    ;   member(M, [Measure|Limits]),
        unknown_in(M, Module, Missing)
    ->  State = unknown, Low = 0, High = 1,
        Detail = missing(Missing)
    ).

%   A value inside a region that it would more probably miss says nothing. And more of a thing may
%   be there than was seen: too few is not known to be too few.
outcome(count(_), at_least, [Margin-_], _, unknown, 0, 1) :-
    Margin < 0,
    !.
outcome(_, _, Margins, Degree, State, Degree, Degree) :-
    (   member(Margin-_, Margins),
        Margin < 0
    ->  State = fails
    ;   Degree < 0.5
    ->  State = unknown
    ;   State = holds
    ).

%   Margins are the signed distances, with variance, to the region's two edges; inside all are >= 0.
region(near, quantity(V, S, _), [quantity(T, R, _), quantity(W, _, _)], [A-Var, B-Var], near(T, W)) :-
    Var is S + R,
    A is V - T + W,
    B is T + W - V.
region(between, quantity(V, S, _), [quantity(L, R, _), quantity(H, Q, _)], [A-VarA, B-VarB],
       between(L, H)) :-
    A is V - L, VarA is S + R,
    B is H - V, VarB is S + Q.
region(at_least, quantity(V, S, _), [quantity(L, R, _)], [A-Var], at_least(L)) :-
    A is V - L, Var is S + R.
region(at_most, quantity(V, S, _), [quantity(H, Q, _)], [B-Var], at_most(H)) :-
    B is H - V, Var is S + Q.

values([], _, []).
values([Expression|Expressions], Module, [Value|Values]) :-
    value(Expression, Module, Value),
    values(Expressions, Module, Values).

%   The mass between two edges is 1 less what lies beyond each.
mass_within([], Sum, Mass) :-
    Mass is max(0.0, min(1.0, Sum)).
mass_within([Margin-Var|Margins], Sum0, Mass) :-
    mass(Margin, Var, M),
    Sum is Sum0 + M - 1,
    mass_within(Margins, Sum, Mass).

%   Probability that a normal variable of this mean and variance is not negative.
mass(Mean, Var, Mass) :-
    (   Var > 0
    ->  Mass is 0.5*erfc(-Mean/sqrt(2*Var))
    ;   Mean >= 0
    ->  Mass = 1
    ;   Mass = 0
    ).

comparable(Test, quantity(_, _, Kind), quantity(Limit, _, LimitKind)) :-
    dimension(Kind, D),
    (   dimension(LimitKind, D)
    ->  true
    ;   Limit =:= 0
    ->  true
    ;   type_error(comparable, Test)
    ).

                 /*******************************
                 *          QUANTITIES          *
                 *******************************/

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
    ->  true
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
    V is X * Y,
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
value(Measure, _, quantity(V, S, Kind)) :-
    callable(Measure),
    measure(Measure, V, Sd, Kind),
    !,
    S is Sd*Sd.

sum_terms(A, B, Module, X, Y, S, Kind) :-
    value(A, Module, QX),
    value(B, Module, QY),
    QX = quantity(X, SX, Kind),
    QY = quantity(Y, SY, _),
    comparable(A + B, QX, QY),
    S is SX + SY.

named_tolerance(Name, Module, X) :-
    current_predicate(Module:tolerance/2),
    Module:tolerance(Name, X),
    !.
named_tolerance(Name, _, X) :-
    vocabulary:tolerance(Name, X).

%   Power of length of a kind.
dimension(length, 1) :- !.
dimension(area, 2) :- !.
dimension(power(D), D) :- !.
dimension(_, 0).

kind(0, ratio) :- !.
kind(1, length) :- !.
kind(2, area) :- !.
kind(D, power(D)).

%   The first measure of an expression that the scene does not know.
unknown_in(Expression, Module, Missing) :-
    \+ value(Expression, Module, _),
    (   Expression =.. [Operator, A, B],
        memberchk(Operator, [+, -, *, /])
    ->  ( unknown_in(A, Module, Missing) -> true ; unknown_in(B, Module, Missing) )
    ;   Missing = Expression
    ).

                 /*******************************
                 *            MODELS            *
                 *******************************/

%!  judge(+Module, +Model, +Thing, -Verdict) is det.
%
%   Verdict is verdict(Model, Thing, State, Low, High, Parts, Sizes, Conditions, Also): the best
%   assignment of faces to the parts of Model, of all that the model's candidate/3 proposes.
%   Parts is a list of Role-Face, Sizes of size(Name, Value, Sd), Conditions of
%   condition(Label, Reason, Proof); Also counts the other assignments that hold.

judge(Module, Model, Thing, Verdict) :-
    Module:model(Model, _, Roles),
    findall(Judged,
            ( distinct_candidate(Module, Model, Thing, Parts),
              judge_parts(Module, Model, Thing, Parts, Judged) ),
            All),
    (   All == []
    ->  Verdict = verdict(Model, Thing, unknown, 0, 1, [], [], [], 0)
    ;   sort(1, @>=, All, [judged(_, State, Low, High, Parts, Conditions)|_]),
        pairs_keys_values(Roled, Roles, Parts),
        sizes(Module, Model, Thing, Parts, Sizes),
        aggregate_all(count, member(judged(_, holds, _, _, _, _), All), Holding),
        Also is max(0, Holding - 1),
        Verdict = verdict(Model, Thing, State, Low, High, Roled, Sizes, Conditions, Also)
    ).

distinct_candidate(Module, Model, Thing, Parts) :-
    findall(Parts, Module:candidate(Model, Thing, Parts), Bag),
    sort(Bag, Candidates),
    member(Parts, Candidates).

judge_parts(Module, Model, Thing, Parts, judged(Rank, State, Low, High, Parts, Conditions)) :-
    findall((Label-Reason)-Test,
            Module:condition(Model, Label, Reason, Thing, Parts, Test),
            Tests),
    pairs_keys_values(Tests, Names, Plain),
    evaluate_all(Plain, Module, Proofs),
    maplist(named_condition, Names, Proofs, Conditions),
    combine(all, Proofs, State, Low, High, _),
    rank(State, Low, High, Proofs, Rank).

named_condition(Label-Reason, Proof, condition(Label, Reason, Proof)).

%   Greater is better: what holds, then what is open, then the nearest miss, which is the one with
%   the most conditions that hold and, among those, the fewest that fail.
rank(State, Low, High, Proofs, rank(Order, Holding, Failing, Low, High)) :-
    nth0(Order, [fails, unknown, holds], State),
    aggregate_all(count, member(proof(holds, _, _, _, _, _), Proofs), Holding),
    aggregate_all(count, member(proof(fails, _, _, _, _, _), Proofs), Failing0),
    Failing is -Failing0.

sizes(Module, Model, Thing, Parts, Sizes) :-
    (   current_predicate(Module:size/5)
    ->  findall(size(Name, V, Sd),
                ( Module:size(Model, Thing, Parts, Name, Measure),
                  value(Measure, Module, quantity(V, Var, length)),
                  Sd is sqrt(Var) ),
                Sizes)
    ;   Sizes = []
    ).
