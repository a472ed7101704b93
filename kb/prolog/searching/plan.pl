:- module(facetlog_plan, [ plan/3,            % +Module, +Model, -Plan
                           test_cost/2        % +Test, -Cost
                         ]).

/** <module> In which order conditions are asked

The cheapest first (search.pl): what costs little may decide that the rest need not be asked.
*/

:- use_module(library(lists)).
:- use_module(library(pairs)).
:- use_module(library(apply)).
:- use_module(facetlog_kb(degrees)).

%!  plan(+Module, +Model, -Plan) is det.
%
%   Plan is a list of group(label(Label), Most), the cheapest conditions first; Most bounds how many
%   conditions this group and all later ones can give.

plan(Module, Model, Plan) :-
    findall(Label-line(Cost, Most), condition_line(Module, Model, Label, Cost, Most), Lines),
    (   Lines \== [],
        forall(member(Label-_, Lines), ground(Label))
    ->  sort(1, @=<, Lines, Sorted),
        group_pairs_by_key(Sorted, Groups),
        findall(Cost-group(label(Label), Most), ( member(Label-All, Groups), together(All, Cost, Most) ),
                Costed),
        sort(0, @>=, Costed, Dearest),
        accumulate(Dearest, 0, [], Plan)
    ;   unbounded(Most),
        Plan = [group(label(_), Most)]
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

%!  test_cost(+Test, -Cost) is det.

test_cost(Test, Cost) :-
    (   var(Test)
    ->  Cost = 1
    ;   Test = is_a(_, _)
    ->  body_cost(Cost)
    ;   Test = after(_, Of)             % what specialise.pl puts off
    ->  body_cost(Body),
        test_cost(Of, One),
        Cost is Body + One
    ;   catch(form(Test, _, Parts, _), error(_, _), fail)
    ->  parts_cost(Parts, Cost)
    ;   Cost = 1
    ).

parts_cost(tests(Tests), Cost) :-
    (   is_list(Tests)
    ->  maplist(test_cost, Tests, Costs),
        sum_list(Costs, Cost)
    ;   quantified(Cost)
    ).
parts_cost(over(_, _, Test), Cost) :- quantified_cost(Test, Cost).
parts_cost(groups(_, _, Test), Cost) :- quantified_cost(Test, Cost).
parts_cost(closed(Test, Parts), Cost) :-
    parts_cost(tests([Test]), One),
    parts_cost(Parts, Others),
    Cost is One + Others.

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
