:- module(facetlog_check_tests, [ test_fault/3,        % +Test, +Position, -Fault
                                  measure_fault/3,     % +Measure, +Position, -Fault
                                  steps_fault/3        % +Steps, +Position, -Fault
                                ]).

/** <module> What is wrong with a test

A test is a term over the words of the vocabulary and those that the text itself defines. Scope and
Fault are those of check.pl; these predicates enumerate all faults.
*/

:- use_module(library(lists)).
:- use_module(facetlog_kb(positions)).
:- use_module(facetlog_kb(spelling)).
:- use_module(facetlog_kb(words)).
:- use_module(facetlog_kb(named_models)).
:- use_module(facetlog(vocabulary)).
:- use_module(facetlog(measures)).

%!  test_fault(+Test, +Position, -Fault) is nondet.
%
%   What is still a variable is bound by the clause's body and checked when it is asked.

test_fault(Test, _, _) :-
    var(Test),
    !,
    fail.
test_fault(Test, Position, Fault) :-
    test_form(Test, Form),
    !,
    arg(Index, Form, Sort),
    arg(Index, Test, Part),
    argument_position(Position, Index, At),
    part_fault(Sort, Part, At, Fault).
test_fault(Test, Position, Fault) :-
    \+ callable(Test),
    !,
    fault_at(Position, "this is no test", [], Fault).
test_fault(Test, Position, Fault) :-
    functor(Test, Name, Arity),
    functor(General, Name, Arity),
    \+ known_relation(General),
    \+ derived_word(General),
    findall(Known, ( member(Sort, [relation, test]), known_word(Sort, Known) ), Words),
    name_position(Position, At),
    unknown_term(Name/Arity, Words, "test", At, Fault).

part_fault(test, Test, Position, Fault) :-
    test_fault(Test, Position, Fault).
part_fault(tests, Tests, Position, Fault) :-
    (   is_list(Tests)
    ->  nth1(Index, Tests, Test),
        element_position(Position, Index, At),
        test_fault(Test, At, Fault)
    ;   nonvar(Tests),
        fault_at(Position, "a list of tests is wanted: [Test, Test]", [], Fault)
    ).
part_fault(comparison, Test, Position, Fault) :-
    nonvar(Test),
    (   test_form(Test, Form),
        Form \= fading(_, _),
        Form \= soft(_, _),
        arg(_, Form, measure)
    ->  test_fault(Test, Position, Fault)
    ;   fault_at(Position, "a comparison is wanted: near, at_least, at_most or between", [], Fault)
    ).
part_fault(count, Count, Position, Fault) :-
    nonvar(Count),
    \+ ( integer(Count), Count >= 0 ),
    fault_at(Position, "how many is a whole number", [], Fault).
part_fault(groups, Groups, Position, Fault) :-
    \+ may_be_groups(Groups),
    fault_at(Position, "a list of lists is wanted: [[A, B], [C]]", [], Fault).
part_fault(model, Model, Position, Fault) :-
    nonvar(Model),
    \+ atom(Model),
    fault_at(Position, "a model's name is a small word: box", [], Fault).
part_fault(model, Model, Position, Fault) :-
    atom(Model),
    unknown_model(Model, Hint),
    fault_at(Position, "there is no model ~q~w", [Model, Hint], Fault).
part_fault(measure, Measure, Position, Fault) :-
    measure_fault(Measure, Position, Fault).
part_fault(weight, Weight, Position, Fault) :-
    nonvar(Weight),
    \+ ( number(Weight), Weight >= 0, Weight =< 1 ),
    fault_at(Position, "the weight of expect is a number from 0 to 1", [], Fault).
part_fault(share, Share, Position, Fault) :-
    nonvar(Share),
    \+ ( number(Share), Share >= 0, Share =< 1 ),
    fault_at(Position, "the share of soft is a number from 0 to 1", [], Fault).

may_be_groups(Groups) :-
    (   ( var(Groups) ; Groups == [] )
    ->  true
    ;   Groups = [Group|Others],
        ( var(Group) ; is_list(Group) ; Group = [_|_] ),
        !,
        may_be_groups(Others)
    ).

%!  measure_fault(+Measure, +Position, -Fault) is nondet.
%
%   What is wrong with an expression of measures: an unknown name, with what is spelt nearly so, or what
%   cannot be one. A variable or a number is right.

measure_fault(Measure, _, _) :-
    ( var(Measure) ; number(Measure) ),
    !,
    fail.
measure_fault(tolerance(Name), Position, Fault) :-
    !,
    atom(Name),
    \+ vocabulary_tolerance(Name),
    findall(Known, vocabulary_tolerance(Known), Names),
    hint(Name, Names, Hint),
    argument_position(Position, 1, At),
    fault_at(At, "there is no tolerance ~q~w", [Name, Hint], Fault).
measure_fault(Expression, Position, Fault) :-
    compound(Expression),
    functor(Expression, Operator, Arity),
    memberchk(Operator/Arity, [(+)/2, (-)/2, (*)/2, (/)/2, (-)/1]),
    !,
    arg(Index, Expression, Part),
    argument_position(Position, Index, At),
    measure_fault(Part, At, Fault).
measure_fault(Summary, Position, Fault) :-
    compound(Summary),
    memberchk(Summary, [ lowest(List), highest(List), sum(List), mean(List),
                         smallest_step(List), largest_step(List), order(List) ]),
    !,
    argument_position(Position, 1, At),
    measures_fault(List, At, Fault).
measure_fault(Measure, Position, Fault) :-
    \+ callable(Measure),
    !,
    fault_at(Position, "this is no measure", [], Fault).
measure_fault(Measure, Position, Fault) :-
    functor(Measure, Name, Arity),
    functor(General, Name, Arity),
    \+ known_measure(General),
    findall(Known, known_word(measure, Known), Words),
    name_position(Position, At),
    unknown_term(Name/Arity, Words, "measure", At, Fault).

%!  steps_fault(+Steps, +Position, -Fault) is nondet.
%
%   Steps are those of as_far_as_seen/3.

steps_fault(Steps, Position, Fault) :-
    (   is_list(Steps)
    ->  nth1(Index, Steps, Step),
        nonvar(Step),
        element_position(Position, Index, At),
        step_fault(Step, At, Fault)
    ;   nonvar(Steps),
        fault_at(Position, "a list of steps is wanted: [step(A, 3, Test), step(B, 3, Test)]", [],
                 Fault)
    ).

step_fault(step(Part, Count, Test), Position, Fault) :-
    !,
    (   nonvar(Part),
        argument_position(Position, 1, At),
        fault_at(At, "a step begins with the variable that it binds", [], Fault)
    ;   argument_position(Position, 2, At),
        part_fault(count, Count, At, Fault)
    ;   argument_position(Position, 3, At),
        test_fault(Test, At, Fault)
    ).
step_fault(_, Position, Fault) :-
    fault_at(Position, "a step is step(Variable, Count, Test)", [], Fault).

measures_fault(List, Position, Fault) :-
    (   is_list(List)
    ->  nth1(Index, List, Measure),
        element_position(Position, Index, At),
        measure_fault(Measure, At, Fault)
    ;   nonvar(List),
        fault_at(Position, "a list of measures is wanted: [area(A), area(B)]", [], Fault)
    ).

unknown_term(Name/Arity, Words, Sort, At, Fault) :-
    (   member(Name/Other, Words)
    ->  fault_at(At, "the ~w ~q is ~q, not ~q", [Sort, Name, Name/Other, Name/Arity], Fault)
    ;   findall(N, member(N/_, Words), Names0),
        sort(Names0, Names),
        hint(Name, Names, Hint),
        fault_at(At, "~q is no ~w of the vocabulary~w", [Name/Arity, Sort, Hint], Fault)
    ).
