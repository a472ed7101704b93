:- module(facetlog_evaluate, [ evaluate/3,    % +Test, +Module, -Proof
                               outline/3,     % +Test, +Module, -Outline
                               state/3,       % +Test, +Module, -State
                               meaning/3      % +Word, +Module, -Test
                             ]).

/** <module> Tests into proofs

A test is a term over the words of the vocabulary. Evaluating one gives

    proof(State, Low, High, Test, Detail, Children)

State is holds, fails or unknown, as the measured values say (the paper's crisp answer). Low and
High bound the probability that the *true* values lie within the tolerances, from the standard
deviations: equal where all was measured, 0 and 1 where nothing is known. Detail is

  - compared(Value, Sd, Kind, Within, Margin): Within is near(Target, Tolerance),
    between(Low, High), at_least(Limit) or at_most(Limit), all in numbers, or fading(Within, Width)
    of one of these; Margin is
    margin(Side, Distance, Sd): the signed distance to the nearer edge of the region, negative
    outside it, with the deviation of that difference; Side is below or above, where that edge is;
  - uncertain(Value, Sd, Kind, Within, Margin): the same, but it cannot be told;
  - missing(Measure, Cause): what the scene does not know, and why (missing_because/2);
  - fact(Truth, Cause): a relation, true, false or unknown; Cause is none unless it is unknown;
  - short: a word of the model or the vocabulary, whose meaning is the only child;
  - counted(Holding, Open, Deciding): how many groups hold and how many may; Deciding is the member
    whose proof decides, or none. The children prove the best member of each group, the best first;
  - judged(Cause): what another model says of a thing;
  - all, any, not, if_known, not_asked, implies, expect(Weight): what became of the children. The
    Test of such a step does not repeat them: it is this word, or each(List), some(List),
    each_pair(List), at_least_of(Count, Groups), at_most_of(Count, Groups).

Probabilities of conditions are multiplied (the least error for the box's three angles, against
minimum and sum); alternatives take the greatest.

Three predicates ask the same tests: evaluate/3 proves, outline/3 gives the numbers without the
proof, state/3 the state alone, which needs to look at no more than decides it.
*/

:- use_module(library(lists)).
:- use_module(library(error)).
:- use_module(facetlog_kb(compare)).
:- use_module(facetlog_kb(connectives)).
:- use_module(facetlog_kb(counted)).
:- use_module(facetlog_kb(model_test)).
:- use_module(facetlog(vocabulary)).

% Arithmetic is most of the work: compiled, it takes half the time. The flag ends with the file.
:- set_prolog_flag(optimise, true).

%!  evaluate(+Test, +Module, -Proof) is det.
%
%   Proof of Test in the current scene. Module may define words by means/2 and named tolerances by
%   tolerance/2.
%
%   @error existence_error(word, Name/Arity) if Test is not in the vocabulary.
%   @error type_error(comparable, Test) if a length is compared with a bare number, or the like.

evaluate(Test, Module, proof(State, Low, High, Shown, Detail, Children)) :-
    sort_of(Test, Module, Sort),
    evaluate_sort(Sort, Test, Module, Shown, State, Low, High, Detail, Children).

evaluate_sort(comparison(Measure, Bounds), Test, Module, Test, State, Low, High, Detail, []) :-
    compare(Measure, Bounds, Module, Test, Compared),
    judged(Compared, State, Low, High),
    detail(Compared, State, Detail).
evaluate_sort(connective(How, Shown, Tests), _, Module, Shown, State, Low, High, Detail, Proofs) :-
    evaluate_all(Tests, Module, Proofs),
    combine(How, Proofs, State, Low, High, Detail).
evaluate_sort(relation(Truth), Test, _, Test, State, Low, High, fact(Truth, Cause), []) :-
    truth(Truth, State, Low, High),
    (   Truth == unknown
    ->  missing_because(Test, Cause)
    ;   Cause = none
    ).
evaluate_sort(counted(Bound, Count, Groups), Test, Module, Shown, State, Low, High, Detail,
              Proofs) :-
    counted_shown(Test, Shown),
    evaluate_counted(Bound, Count, Groups, Module, State, Low, High, Detail, Proofs).
evaluate_sort(is_a(Thing, Model), Test, _, Test, State, Low, High, judged(Cause), []) :-
    model_outcome(Thing, Model, outcome(State, Low, High, Cause)).
evaluate_sort(meaning(Meaning), Test, Module, Test, State, Low, High, short, [Proof]) :-
    evaluate(Meaning, Module, Proof),
    Proof = proof(State, Low, High, _, _, _).

evaluate_all([], _, []).
evaluate_all([Test|Tests], Module, [Proof|Proofs]) :-
    evaluate(Test, Module, Proof),
    evaluate_all(Tests, Module, Proofs).

%   What sort of test it is, with what the sort needs.
sort_of(Test, Module, Sort) :-
    (   var(Test)
    ->  instantiation_error(Test)
    ;   comparison(Test, Measure, Bounds)
    ->  Sort = comparison(Measure, Bounds)
    ;   connective(Test, How, Shown, Tests)
    ->  Sort = connective(How, Shown, Tests)
    ;   relation(Test, Truth)
    ->  Sort = relation(Truth)
    ;   counted(Test, Bound, Count, Groups)
    ->  Sort = counted(Bound, Count, Groups)
    ;   Test = is_a(Thing, Model)
    ->  Sort = is_a(Thing, Model)
    ;   meaning(Test, Module, Meaning)
    ->  Sort = meaning(Meaning)
    ;   functor(Test, Name, Arity),
        existence_error(word, Name/Arity)
    ).

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
                 *            OUTLINE           *
                 *******************************/

%!  outline(+Test, +Module, -Outline) is det.
%
%   Outline is outline(State, Low, High, Miss): as evaluate/3 has them, without the proof. Miss says
%   by how much Test fails, from 0 (it does not) to 1 (nothing of it is there), see miss/2; it does
%   not depend on the order of a test's parts. What can change none of these any more is not asked.
%
%   @error as evaluate/3

outline(Test, Module, outline(State, Low, High, Miss)) :-
    sort_of(Test, Module, Sort),
    outline_sort(Sort, Test, Module, State, Low, High, Miss).

outline_sort(comparison(Measure, Bounds), Test, Module, State, Low, High, Miss) :-
    compare(Measure, Bounds, Module, Test, Compared),
    judged(Compared, State, Low, High),
    (   State == fails
    ->  miss(Compared, Miss)
    ;   Miss = 0
    ).
outline_sort(relation(Truth), _, _, State, Low, High, Miss) :-
    truth(Truth, State, Low, High),
    whole_miss(State, Miss).
outline_sort(counted(Bound, Count, Groups), _, Module, State, Low, High, Miss) :-
    outline_counted(Bound, Count, Groups, Module, State, Low, High, Miss).
outline_sort(is_a(Thing, Model), _, _, State, Low, High, Miss) :-
    model_outcome(Thing, Model, outcome(State, Low, High, _)),
    whole_miss(State, Miss).
outline_sort(meaning(Meaning), _, Module, State, Low, High, Miss) :-
    outline(Meaning, Module, outline(State, Low, High, Miss)).
outline_sort(connective(How, _, Tests), _, Module, State, Low, High, Miss) :-
    outline_connective(How, Tests, Module, State, Low, High, Miss).

outline_connective(all, Tests, Module, State, Low, High, Miss) :-
    outline_all(Tests, Module, all(holds, 1, 1, 1, []), State, Low, High, Misses),
    joint_miss(Misses, Miss).
outline_connective(any, Tests, Module, State, Low, High, Miss) :-
    outline_any(Tests, Module, any(fails, 0, 0, 1), State, Low, High, Least),
    ( State == fails -> Miss = Least ; Miss = 0 ).
outline_connective(not, [Test], Module, State, Low, High, Miss) :-
    outline(Test, Module, outline(S, L, H, _)),
    opposite(S, L, H, State, Low, High),
    whole_miss(State, Miss).
outline_connective(if_known, [Test], Module, State, Low, High, Miss) :-
    outline(Test, Module, outline(S, L, H, Miss)),
    (   S == unknown
    ->  State = holds, Low = 1, High = 1
    ;   State = S, Low = L, High = H
    ).
outline_connective(implies, [Where, Test], Module, State, Low, High, Miss) :-
    outline(Where, Module, outline(S0, L0, H0, _)),
    opposite(S0, L0, H0, S1, L1, H1),
    (   S1 == holds,
        L1 >= 1
    ->  State = S1, Low = L1, High = H1, Miss = 0
    ;   outline(Test, Module, outline(S2, L2, H2, Miss2)),
        either(S1, S2, State),
        Low is max(L1, L2),
        High is max(H1, H2),
        ( State == fails -> Miss = Miss2 ; Miss = 0 )
    ).
outline_connective(expect(Weight), [Test], Module, holds, Low, High, 0) :-
    outline(Test, Module, outline(_, L, H, _)),
    expected(Weight, L, H, Low, High).

outline_all([], _, all(S, L, H, _, Misses), S, L, H, Misses).
outline_all([Test|Tests], Module, all(S0, L0, H0, Left0, Misses0), S, L, H, Misses) :-
    outline(Test, Module, outline(S1, L1, H1, Miss)),
    both(S0, S1, S2),
    L2 is L0*L1,
    H2 is H0*H1,
    (   S1 == fails
    ->  Misses1 = [Miss|Misses0],
        Left is Left0*(1 - Miss)
    ;   Misses1 = Misses0,
        Left = Left0
    ),
    (   nothing_left(Left),
        nothing_left(H2)
    ->  S = S2, L = L2, H = H2, Misses = Misses1
    ;   outline_all(Tests, Module, all(S2, L2, H2, Left, Misses1), S, L, H, Misses)
    ).

outline_any([], _, any(S, L, H, Miss), S, L, H, Miss).
outline_any([Test|Tests], Module, any(S0, L0, H0, Miss0), S, L, H, Miss) :-
    outline(Test, Module, outline(S1, L1, H1, Miss1)),
    either(S0, S1, S2),
    L2 is max(L0, L1),
    H2 is max(H0, H1),
    ( S1 == fails -> Miss2 is min(Miss0, Miss1) ; Miss2 = Miss0 ),
    (   S2 == holds,
        L2 >= 1
    ->  S = S2, L = L2, H = H2, Miss = Miss2
    ;   outline_any(Tests, Module, any(S2, L2, H2, Miss2), S, L, H, Miss)
    ).

whole_miss(State, Miss) :-
    ( State == fails -> Miss = 1 ; Miss = 0 ).

%   Several misses count more than the worst of them, and never more than 1. They are taken in order
%   of size, for rounding would tell the order of the tests otherwise.
joint_miss(Misses, Miss) :-
    msort(Misses, Sorted),
    left_over(Sorted, 1, Left),
    ( nothing_left(Left) -> Miss = 1 ; Miss is 1 - Left ).

left_over([], Left, Left).
left_over([Miss|Misses], Left0, Left) :-
    Left1 is Left0*(1 - Miss),
    left_over(Misses, Left1, Left).

%   So little is taken as nothing: search.pl compares whole multiples of 1.0e-9.
nothing_left(Left) :-
    Left < 1.0e-10.

                 /*******************************
                 *             STATE            *
                 *******************************/

%!  state(+Test, +Module, -State) is det.
%
%   The state that evaluate/3 would give, asked of no more of Test than decides it.
%
%   @error as evaluate/3

state(Test, Module, State) :-
    sort_of(Test, Module, Sort),
    state_sort(Sort, Test, Module, State).

state_sort(comparison(Measure, Bounds), Test, Module, State) :-
    compare(Measure, Bounds, Module, Test, Compared),
    judged(Compared, State, _, _).
state_sort(relation(Truth), _, _, State) :-
    truth(Truth, State, _, _).
state_sort(counted(Bound, Count, Groups), _, Module, State) :-
    state_counted(Bound, Count, Groups, Module, State).
state_sort(is_a(Thing, Model), _, _, State) :-
    model_state(Thing, Model, State).
state_sort(meaning(Meaning), _, Module, State) :-
    state(Meaning, Module, State).
state_sort(connective(How, _, Tests), _, Module, State) :-
    state_connective(How, Tests, Module, State).

state_connective(all, Tests, Module, State) :-
    state_all(Tests, Module, holds, State).
state_connective(any, Tests, Module, State) :-
    state_any(Tests, Module, fails, State).
state_connective(not, [Test], Module, State) :-
    state(Test, Module, S),
    opposite_state(S, State).
state_connective(if_known, [Test], Module, State) :-
    state(Test, Module, S),
    ( S == unknown -> State = holds ; State = S ).
state_connective(implies, [Where, Test], Module, State) :-
    state(Where, Module, S0),
    opposite_state(S0, S1),
    (   S1 == holds
    ->  State = holds
    ;   state(Test, Module, S2),
        either(S1, S2, State)
    ).
state_connective(expect(_), _, _, holds).

state_all([], _, State, State).
state_all([Test|Tests], Module, State0, State) :-
    state(Test, Module, State1),
    (   State1 == fails
    ->  State = fails
    ;   both(State0, State1, State2),
        state_all(Tests, Module, State2, State)
    ).

state_any([], _, State, State).
state_any([Test|Tests], Module, State0, State) :-
    state(Test, Module, State1),
    (   State1 == holds
    ->  State = holds
    ;   either(State0, State1, State2),
        state_any(Tests, Module, State2, State)
    ).
