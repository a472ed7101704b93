:- module(facetlog_search, [ start/4,         % +Aim, +Candidates, +Plan, -Queue
                             next_best/4,     % +Aim, +Queue0, -Queue, -Found
                             total/2,         % +Misses, -Total
                             key/3,           % +Sought, +Open, -Key
                             improbability/2, % +Probability, -Whole
                             plan/3,          % +Module, +Model, -Plan
                             candidates/4,    % +Module, +Model, +Thing, -Candidates
                             in_all/2         % +Found, -State
                           ]).

/** <module> The best assignments of faces to parts, best first

Conditions are asked one by one, the cheapest first, and always of the assignment that is still the
most promising: its key is a bound that no further condition can better, so the first one of which
nothing is left to ask is the best of all, and most of the others are never asked the costly
questions. What is kept of each is a tally, no proof.

An assignment of which all conditions hold comes before all others; then the most conditions that
hold; the fewest that fail; the least total miss (outline/3), to which each condition adds 1 at most;
the greatest probability, where nothing fails; the names. Neither the order of conditions nor that of
facts is seen. (To count failures first would favour what nothing is known about.)

An aim is aim(Sought, Module, Model). Who seeks a `miss` has just that order. Who seeks a `verdict`
must know first whether anything is left open, for then the thing is not refuted: what does not fail
comes before all that does. Where all fail, both see the same order.
*/

:- use_module(library(lists)).
:- use_module(library(heaps)).
:- use_module(library(pairs)).
:- use_module(library(apply)).
:- use_module(facetlog_kb(evaluate)).
:- use_module(facetlog_kb(in_progress)).

                 /*******************************
                 *             QUEUE            *
                 *******************************/

%!  candidates(+Module, +Model, +Thing, -Candidates) is det.
%
%   Candidates is the sorted list of Thing-Parts that the model proposes.

candidates(Module, Model, Thing, Candidates) :-
    while_judging(Module, Model, Thing,
                  findall(Thing-Parts, Module:candidate(Model, Thing, Parts), Bag)),
    sort(Bag, Candidates).

%!  start(+Aim, +Candidates, +Plan, -Queue) is det.

start(aim(Sought, _, _), Candidates, Plan, Queue) :-
    findall(Key-Open,
            ( member(Thing-Parts, Candidates),
              Open = open(Thing, Parts, tally(0, 0, 0, 1, 1, []), Plan),
              key(Sought, Open, Key) ),
            Pairs),
    list_to_heap(Pairs, Queue).

%!  next_best(+Aim, +Queue0, -Queue, -Found) is semidet.
%
%   Found is found(Thing, Parts, Tally), the best of Queue0; Queue holds the rest. Fails if none is
%   left.

next_best(Aim, Queue0, Queue, Found) :-
    get_from_heap(Queue0, _, Open, Queue1),
    go_on(Open, Aim, Queue1, Queue, Found).

go_on(open(Thing, Parts, Tally, []), _, Queue, Queue, found(Thing, Parts, Tally)) :-
    !.
go_on(Open0, Aim, Queue0, Queue, Found) :-
    ask_next(Open0, Aim, Open),
    Aim = aim(Sought, _, _),
    key(Sought, Open, Key),
    (   min_of_heap(Queue0, Least, _),
        Least @< Key
    ->  add_to_heap(Queue0, Key, Open, Queue1),
        next_best(Aim, Queue1, Queue, Found)
    ;   go_on(Open, Aim, Queue0, Queue, Found)
    ).

ask_next(open(Thing, Parts, Tally0, [group(Label, _)|Groups]), aim(_, Module, Model),
         open(Thing, Parts, Tally, Groups)) :-
    (   noted(Module, Model, Thing)     % where one thing is judged: most is asked there
    ->  ask(Module, Model, Label, Thing, Parts, Tally0, Tally)
    ;   while_judging(Module, Model, Thing,
                      ask(Module, Model, Label, Thing, Parts, Tally0, Tally))
    ).

ask(Module, Model, Label, Thing, Parts, Tally0, Tally) :-
    findall(Test, Module:condition(Model, Label, _, Thing, Parts, Test), Tests),
    count_in(Tests, Module, Tally0, Tally).

count_in([], _, Tally, Tally).
count_in([Test|Tests], Module, Tally0, Tally) :-
    outline(Test, Module, Outline),
    count_one(Outline, Tally0, Tally1),
    count_in(Tests, Module, Tally1, Tally).

%!  count_all(+Outlines, +Tally0, -Tally) is det.

count_all([], Tally, Tally).
count_all([Outline|Outlines], Tally0, Tally) :-
    count_one(Outline, Tally0, Tally1),
    count_all(Outlines, Tally1, Tally).

count_one(outline(State, L, P, Miss), tally(H0, F0, U0, L0, P0, Misses0),
          tally(H1, F1, U1, L1, P1, Misses1)) :-
    L1 is L0*L,
    P1 is P0*P,
    count_state(State, Miss, H0, F0, U0, Misses0, H1, F1, U1, Misses1).

count_state(holds, _, H0, F, U, Misses, H, F, U, Misses) :- H is H0 + 1.
count_state(unknown, _, H, F, U0, Misses, H, F, U, Misses) :- U is U0 + 1.
count_state(fails, Miss, H, F0, U, Misses, H, F, U, [Miss|Misses]) :- F is F0 + 1.

%!  in_all(+Found, -State) is det.
%
%   What all conditions together say.

in_all(found(_, _, tally(_, Failing, Unknown, _, _, _)), State) :-
    state_of(Failing, Unknown, State).

state_of(Failing, Unknown, State) :-
    (   Failing > 0
    ->  State = fails
    ;   Unknown > 0
    ->  State = unknown
    ;   State = holds
    ).

                 /*******************************
                 *             KEYS             *
                 *******************************/

%!  key(+Sought, +Open, -Key) is det.
%
%   Least is best. No component can shrink when more conditions are asked, so that the key of an
%   assignment half asked is a bound.
key(Sought, open(Thing, Parts, Tally, Groups),
    key(Order, Lacking, F, Total, L, P, Thing, Parts)) :-
    Tally = tally(H, F, U, Low, High, Misses),
    state_of(F, U, State),
    state_order(Sought, State, Order),
    most_left(Groups, Left),
    Lacking is -(H + Left),
    total(Misses, Total),
    (   F > 0
    ->  L = 0, P = 0            % F has grown: the key as a whole has
    ;   improbability(Low, L),
        improbability(High, P)
    ).

state_order(verdict, holds, 0).
state_order(verdict, unknown, 1).
state_order(verdict, fails, 2).
state_order(miss, holds, 0).
state_order(miss, unknown, 1).
state_order(miss, fails, 1).

most_left([], 0).
most_left([group(_, Most)|_], Most).

%   Sums and products of floats depend on the order of their terms in the last digits. They are
%   compared as whole multiples of this, far above such a difference and far below any that matters.
resolution(1.0e-9).

%!  improbability(+Probability, -Whole) is det.
%
%   The less probable the greater, in whole steps of the resolution.

improbability(Probability, Whole) :-
    (   Probability > 0
    ->  resolution(Step),
        Whole is round(-log(Probability)/Step)
    ;   Whole = infinite            % an atom: behind all numbers
    ).

%!  total(+Misses, -Total) is det.
%
%   Their sum, in whole steps of the resolution.

total(Misses, Total) :-
    resolution(Step),
    msort(Misses, Sorted),
    sum_list(Sorted, Sum),
    Total is round(Sum/Step).

                 /*******************************
                 *             PLAN             *
                 *******************************/

%!  plan(+Module, +Model, -Plan) is det.
%
%   Plan is a list of group(Label, Most), the cheapest conditions first; Most bounds how many
%   conditions this group and all later ones can give.

plan(Module, Model, Plan) :-
    findall(Label-line(Cost, Most), condition_line(Module, Model, Label, Cost, Most), Lines),
    (   Lines \== [],
        forall(member(Label-_, Lines), ground(Label))
    ->  sort(1, @=<, Lines, Sorted),
        group_pairs_by_key(Sorted, Groups),
        findall(Cost-group(Label, Most), ( member(Label-All, Groups), together(All, Cost, Most) ),
                Costed),
        sort(0, @>=, Costed, Dearest),
        accumulate(Dearest, 0, [], Plan)
    ;   unbounded(Most),
        Plan = [group(_, Most)]
    ).

%   From the last to the first: what each and all after it can give.
accumulate([], _, Plan, Plan).
accumulate([_-group(Label, Most)|Groups], After, Plan0, Plan) :-
    From is After + Most,
    accumulate(Groups, From, [group(Label, From)|Plan0], Plan).

together(Lines, Cost, Most) :-
    findall(C, member(line(C, _), Lines), Costs),
    sum_list(Costs, Cost),
    findall(M, member(line(_, M), Lines), Mosts),
    sum_list(Mosts, Most).

%   Cost of a clause of condition/6, and how many conditions it can give.
condition_line(Module, Model, Label, Cost, Most) :-
    predicate_property(Module:condition(_, _, _, _, _, _), number_of_clauses(_)),
    clause(Module:condition(Model, Label, _, _, _, Test), Body),
    test_cost(Test, TestCost),
    (   Body == true
    ->  Cost = TestCost,
        Most = 1
    ;   body_cost(BodyCost),
        Cost is TestCost + BodyCost,
        ( at_most_one(Body, Module, 0) -> Most = 1 ; unbounded(Most) )
    ).

unbounded(1000000000).      % conditions: more than any model gives

%   In comparisons. A body searches, and most often for all faces of a thing: far dearer than tests.
%   So does another model.
body_cost(1000).

%   What a quantifier goes through is not known yet; a model has three parts or so.
quantified(3).

test_cost(Test, 1) :-
    var(Test),
    !.
test_cost(all(Tests), Cost) :- !, tests_cost(Tests, Cost).
test_cost(any(Tests), Cost) :- !, tests_cost(Tests, Cost).
test_cost(implies(Where, Test), Cost) :- !, tests_cost([Where, Test], Cost).
test_cost(at_least_of(_, _, _, Test), Cost) :- !, quantified_cost(Test, Cost).
test_cost(at_most_of(_, _, _, Test), Cost) :- !, quantified_cost(Test, Cost).
test_cost(is_a(_, _), Cost) :- !, body_cost(Cost).
test_cost(each(_, _, Test), Cost) :- !, quantified_cost(Test, Cost).
test_cost(some(_, _, Test), Cost) :- !, quantified_cost(Test, Cost).
test_cost(each_pair(_, _, _, Test), Cost) :- !, quantified_cost(Test, Cost).
test_cost(_, 1).

tests_cost(Tests, Cost) :-
    (   is_list(Tests)
    ->  maplist(test_cost, Tests, Costs),
        sum_list(Costs, Cost)
    ;   quantified(Cost)
    ).

quantified_cost(Test, Cost) :-
    quantified(N),
    test_cost(Test, One),
    Cost is N*One.

%!  at_most_one(+Body, +Module, +Depth) is semidet.
%
%   Body is seen to have at most one solution. Only what is sure counts, as bounds rest on it.

at_most_one(Goal, _, _) :-
    var(Goal),
    !,
    fail.
at_most_one(Module:Goal, _, Depth) :- !, at_most_one(Goal, Module, Depth).
at_most_one((A, B), Module, Depth) :-
    !,
    at_most_one(A, Module, Depth),
    at_most_one(B, Module, Depth).
at_most_one((_ -> A ; B), Module, Depth) :-
    !,
    at_most_one(A, Module, Depth),
    at_most_one(B, Module, Depth).
at_most_one((_ -> A), Module, Depth) :- !, at_most_one(A, Module, Depth).
at_most_one(Goal, Module, Depth) :-
    functor(Goal, Name, Arity),
    (   single(Name/Arity)
    ->  true
    ;   deepest(Deepest),
        Depth < Deepest,
        functor(General, Name, Arity),
        predicate_property(Module:General, number_of_clauses(1)),
        \+ predicate_property(Module:General, imported_from(_)),
        clause(Module:General, Body),
        Deeper is Depth + 1,
        at_most_one(Body, Module, Deeper)
    ).

deepest(8).     % of definitions within definitions; what goes deeper may go round in circles

single(true/0).          single(fail/0).          single((!)/0).
single(= /2).            single(\= /2).            single(== /2).
single(\== /2).          single(is/2).             single(=:= /2).
single(=\= /2).          single(< /2).             single(> /2).
single(=< /2).           single(>= /2).            single(@< /2).
single(@> /2).           single(@=< /2).           single(@>= /2).
single((\+)/1).         single(once/1).           single(forall/2).
single(findall/3).       single(aggregate_all/3).  single(memberchk/2).
single(sort/2).          single(sort/4).           single(msort/2).
single(include/3).       single(exclude/3).        single(reverse/2).
single(sum_list/2).      single(max_list/2).       single(min_list/2).
single(subtract/3).      single(undersides/2).     single(separate/2).
single(longest_first/2). single(holds/1).          single(possible/1).
% What checked files call instead.
single(holds_in/2).      single(possible_in/2).    single(longest_first_in/3).
single(bounded_value/2). single(bounded_values/2).
