:- module(facetlog_check, [ goal_fault/4,        % +Goal, +Position, +Scope, -Fault
                            extended/3,          % +Closure, +Extra, -Goal
                            inner_goal/3,        % +BagGoal, -Variables, -Goal
                            joined_fault/4,      % +Goal, +Position, +Scope, -Fault
                            model_place/2        % +Call, -Argument
                          ]).

/** <module> What is wrong with a goal

A goal is checked before it is run, with all goals inside it, to the bottom: what is not known to be
harmless is a fault. A Scope is an assoc of the predicates beside the vocabulary (Name/Arity), which
are Python's. A fault is fault(Start, End, Format, Args); goal_fault/4 enumerates all faults.
*/

:- use_module(library(assoc)).
:- use_module(library(lists)).
:- use_module(facetlog_kb(positions)).
:- use_module(facetlog_kb(spelling)).
:- use_module(facetlog_kb(white_list)).
:- use_module(facetlog_kb(words)).
:- use_module(facetlog_kb(check_tests)).
:- use_module(facetlog_kb(foreign_signs)).
:- use_module(facetlog_kb(named_models)).
:- use_module(facetlog_kb(joined_names)).

                 /*******************************
                 *             GOALS            *
                 *******************************/

%!  goal_fault(+Goal, +Position, +Scope, -Fault) is nondet.

goal_fault(Goal, Position, _, Fault) :-
    var(Goal),
    !,
    fault_at(Position, "a variable stands where a goal is wanted", [], Fault).
goal_fault(Goal, Position, _, Fault) :-
    number(Goal),
    !,
    fault_at(Position, "this is no goal; decimals are written with a point: 0.5", [], Fault).
goal_fault(Goal, Position, _, Fault) :-
    \+ callable(Goal),
    !,
    fault_at(Position, "this is no goal", [], Fault).
goal_fault(_:_, Position, _, Fault) :-
    !,
    fault_at(Position, "a goal names no module: its words are found by themselves", [], Fault).
goal_fault(Goal, Position, Scope, Fault) :-
    functor(Goal, Name, Arity),
    (   get_assoc(Name/Arity, Scope, _)
    ->  fail
    ;   allowed_word(Goal, Head)
    ->  arguments_fault(Head, Goal, Position, Scope, Fault)
    ;   special(Goal, Head)
    ->  (   arguments_fault(Head, Goal, Position, Scope, Fault)
        ;   quoted_name_fault(Goal, Position, Fault)
        )
    ;   ( search_word(Name/Arity) ; fact_word(Goal) )
    ->  quoted_name_fault(Goal, Position, Fault)
    ;   unknown_word(Name/Arity, Position, Scope, Fault)
    ).

%   No fact and no verdict has a string: what is compared with one is never found.
quoted_name_fault(Goal, Position, Fault) :-
    arg(Index, Goal, Argument),
    string(Argument),
    argument_position(Position, Index, At),
    quoted_fault(Argument, At, Fault).

quoted_fault(String, At, Fault) :-
    (   number_string(Number, String)
    ->  fault_at(At, "a number has no double quotes: write ~w", [Number], Fault)
    ;   atom_string(Name, String),
        fault_at(At, "a name has no double quotes: write ~q", [Name], Fault)
    ).

%!  joined_fault(+Goal, +Position, +Scope, -Fault) is nondet.
%
%   A question compares a constant with what stands for a model, a verdict or a name, and is none.

joined_fault(Goal, Position, Scope, Fault) :-
    joined(Goal, Position, place(Call, Index), Constant-At),
    (   string(Constant)
    ->  ( special(Call, _) ; fact_word(Call) ; functor(Call, Name, Arity), search_word(Name/Arity) ),
        !,
        quoted_fault(Constant, At, Fault)
    ;   sorted_place(Call, Index, Sort),
        argument_fault(Sort, Constant, At, Scope, Fault)
    ).

%   The argument of Call is of a sort whose names are all known: model, state, truth or kind.
sorted_place(Call, Index, Sort) :-
    special(Call, Head),
    arg(Index, Head, Sort),
    compound(Sort),
    memberchk(Sort, [model(_), state(_), truth(_), kind(_)]).
sorted_place(Call, Index, model('Model')) :-
    test_form(Call, Form),
    arg(Index, Form, model).

%!  model_place(+Call, -Argument) is nondet.
%
%   Argument of Call stands for a model.

model_place(Call, Argument) :-
    sorted_place(Call, Index, model(_)),
    arg(Index, Call, Argument).

%   Words with an argument of a sort of its own. That of fact/1 must be seen to be a fact: what is
%   none might act.
special(fact(_), fact(fact('Fact'))).
special(holds(_), holds(test('Test'))).
special(possible(_), possible(test('Test'))).
special(each_pair(_, _, _, _),
        each_pair(hidden('X'), hidden('Y'), 'Faces', test('Test'))).
special(as_far_as_seen(_, _, _), as_far_as_seen('Thing', steps('Steps'), 'Parts')).
special(measure(_, _, _, _), measure(measure('Measure'), 'Value', 'Sd', kind('Kind'))).
special(relation(_, _), relation(test('Relation'), truth('Truth'))).
special(in(_, _), in('Scene', goal('Goal'))).
special(is_a(_, _), is_a('Thing', model('Model'))).
special(verdict(_, _, _, _), verdict('Thing', model('Model'), state('State'), 'Degree')).
special(plays(_, _, _, _), plays('Face', 'Role', 'Thing', model('Model'))).
special(part_in(_, _, _, _), part_in('Thing', model('Model'), 'Role', 'Part')).
special(assignment(_, _, _), assignment(model('Model'), 'Thing', 'Parts')).

unknown_word(Name/_, Position, _, Fault) :-
    sign_advice(Name, Advice),
    !,
    name_position(Position, At),
    fault_at(At, Advice, [], Fault).
unknown_word(Name/Arity, Position, Scope, Fault) :-
    \+ callable_word(Scope, Name/_),
    other_word(Name, Arity, Format, Args),
    !,
    fault_at(Position, Format, Args, Fault).
unknown_word(Name/Arity, Position, Scope, Fault) :-
    findall(Known, callable_word(Scope, Known), Words),
    findall(A, ( member(Name/A, Words), A =\= Arity ), Others),
    (   Others \== []
    ->  same_name(Name, Arity, Others, Format, Args),
        At = Position
    ;   findall(N, member(N/_, Words), Names0),
        sort(Names0, Names),
        right_arity(Name/Arity, Words, Names, Hint),
        Format = "~q is no fact and no word of questions~w",
        Args = [Name/Arity, Hint],
        name_position(Position, At)
    ),
    fault_at(At, Format, Args, Fault).

%   What stands in the arguments of questions' words, and how it is asked.
other_word(Name, _, "~q is a measure: write measure(~w, Value, Sd, Kind)", [Name, Written]) :-
    written_word(measure, Name, Written).
other_word(Name, _, "~q is a test: write holds(~w)", [Name, Written]) :-
    ( Sort = relation ; Sort = test ),
    written_word(Sort, Name, Written).
other_word(Name, Arity, "~q is a model: write is_a(Thing, ~q)", [Name, Name]) :-
    Arity =< 1,
    model_module(Name, _).

written_word(Sort, Name, Written) :-
    known_word(Sort, Name/Arity),
    !,
    term_signature(Sort, Name/Arity, Written).

callable_word(Own, Word) :-
    assoc_to_keys(Own, Words),
    member(Word, Words).
callable_word(_, Word) :-
    member(Sort, [fact, search, question, prolog]),
    known_word(Sort, Word).

%   Of equally near words that with the right number of arguments.
right_arity(Name/Arity, Words, Names, Hint) :-
    findall(N, member(N/Arity, Words), Fitting0),
    sort(Fitting0, Fitting),
    (   nearest(Name, Fitting, Nearest)
    ->  format(string(Hint), "; did you mean ~w?", [Nearest/Arity])
    ;   hint(Name, Names, Hint)
    ).

same_name(Name, Arity, Others, "~q has ~w, not ~d: ~w", [Name, Count, Arity, Signature]) :-
    Others = [Other|_],
    ( Other =:= 1 -> Count = "1 argument" ; format(string(Count), "~d arguments", [Other]) ),
    (   signature(Name/Other, Signature0)
    ->  Signature = Signature0
    ;   Signature = Name/Other
    ).

                 /*******************************
                 *           ARGUMENTS          *
                 *******************************/

arguments_fault(Head, Goal, Position, Scope, Fault) :-
    compound(Head),
    arg(Index, Head, Sort),
    compound(Sort),
    arg(Index, Goal, Argument),
    argument_position(Position, Index, ArgumentPosition),
    argument_fault(Sort, Argument, ArgumentPosition, Scope, Fault).

argument_fault(goal(_), Goal, Position, Scope, Fault) :-
    goal_fault(Goal, Position, Scope, Fault).
argument_fault(inner(_), Goal, Position, Scope, Fault) :-
    goal_fault(Goal, Position, Scope, Fault).
argument_fault(bag(_), Goal0, Position, Scope, Fault) :-
    inner_goal(Goal0, _, Goal),
    (   Goal == Goal0
    ->  Inner = Position
    ;   inner_position(Goal0, Position, Inner)
    ),
    goal_fault(Goal, Inner, Scope, Fault).
argument_fault(closure(Extra, _), Closure, Position, Scope, Fault) :-
    (   nonvar(Closure),
        extended(Closure, Extra, Goal)
    ->  goal_fault(Goal, Position, Scope, Fault)
    ;   goal_fault(Closure, Position, Scope, Fault)
    ).
argument_fault(expression(_), Expression, Position, _, Fault) :-
    expression_fault(Expression, Position, Fault).
argument_fault(summary(_), Summary, Position, _, Fault) :-
    summary_fault(Summary, Position, Fault).
argument_fault(fact(_), Fact, Position, _, Fault) :-
    not_a_fact(Fact, Position, Fault).
argument_fault(test(_), Test, Position, _, Fault) :-
    test_fault(Test, Position, Fault).
argument_fault(steps(_), Steps, Position, _, Fault) :-
    steps_fault(Steps, Position, Fault).
argument_fault(measure(_), Measure, Position, _, Fault) :-
    measure_fault(Measure, Position, Fault).
argument_fault(model(_), Model, Position, _, Fault) :-
    atom(Model),
    !,
    unknown_model(Model, Hint),
    fault_at(Position, "there is no model ~q~w", [Model, Hint], Fault).
argument_fault(model(_), Model, Position, _, Fault) :-
    nonvar(Model),
    \+ string(Model),
    fault_at(Position, "a model's name is wanted here: box", [], Fault).
argument_fault(Sort, Name, Position, _, Fault) :-
    closed_sort(Sort, Names, Format),
    nonvar(Name),
    \+ string(Name),
    \+ memberchk(Name, Names),
    fault_at(Position, Format, [], Fault).

closed_sort(state(_), [holds, fails, unknown], "a verdict is holds, fails or unknown").
closed_sort(truth(_), [true, false, unknown], "a relation is true, false or unknown").
closed_sort(kind(_), [deg, ratio, count, length, area],
            "a measure's kind is deg, ratio, count, length or area").

%!  extended(+Closure, +Extra, -Goal) is semidet.
%
%   Goal is Closure with Extra arguments more. Fails if it is none.

extended(Closure, Extra, Goal) :-
    callable(Closure),
    Closure \= _:_,
    (   compound(Closure)
    ->  compound_name_arguments(Closure, Name, Args)
    ;   Name = Closure,
        Args = []
    ),
    length(More, Extra),
    append(Args, More, All),
    Goal =.. [Name|All].

%!  inner_goal(+BagGoal, -Variables, -Goal) is det.
%
%   BagGoal is Goal behind Var^; Variables is what stands there.

inner_goal(Goal, [], Goal) :-
    var(Goal),
    !.
inner_goal(Variable^Goal0, [Variable|Variables], Goal) :-
    !,
    inner_goal(Goal0, Variables, Goal).
inner_goal(Goal, [], Goal).

inner_position(Goal, Position, Position) :-
    var(Goal),
    !.
inner_position(_^Goal, Position, Inner) :-
    !,
    argument_position(Position, 2, Position1),
    inner_position(Goal, Position1, Inner).
inner_position(_, Position, Position).

not_a_fact(Fact, Position, Fault) :-
    var(Fact),
    !,
    fault_at(Position, "fact/1 needs to know which fact, as in fact(face(F))", [], Fault).
not_a_fact(Fact, _, _) :-
    fact_word(Fact),
    !,
    fail.
not_a_fact(Fact, Position, Fault) :-
    callable(Fact),
    functor(Fact, Name, Arity),
    !,
    findall(Known, known_word(fact, Known), Words),
    findall(N, member(N/_, Words), Names),
    (   member(Name/Other, Words)
    ->  same_name(Name, Arity, [Other], Format, Args),
        fault_at(Position, Format, Args, Fault)
    ;   hint(Name, Names, Hint),
        name_position(Position, At),
        fault_at(At, "~q is no fact~w", [Name/Arity, Hint], Fault)
    ).
not_a_fact(_, Position, Fault) :-
    fault_at(Position, "this is no fact", [], Fault).

                 /*******************************
                 *          ARITHMETIC          *
                 *******************************/

%   The longest number that may stand in an expression, in digits: bounded_numbers.pl.
longest(20_000).

expression_fault(X, _, _) :-
    ( var(X) ; float(X) ; rational(X), \+ integer(X) ),
    !,
    fail.
expression_fault(X, Position, Fault) :-
    integer(X),
    !,
    longest(Longest),
    span(Position, Start, End),
    End - Start > Longest,
    fault_at(Position, "the number is too long: at most ~D digits", [Longest], Fault).
expression_fault(X, Position, Fault) :-
    callable(X),
    functor(X, Name, Arity),
    arithmetic(Name/Arity),
    !,
    compound(X),                        % a constant has no parts
    arg(Index, X, Part),
    argument_position(Position, Index, PartPosition),
    expression_fault(Part, PartPosition, Fault).
expression_fault(X, Position, Fault) :-
    callable(X),
    !,
    functor(X, Name, Arity),
    name_position(Position, At),
    findall(N, arithmetic(N/Arity), Names),
    hint(Name, Names, Hint),
    (   Arity =:= 0,
        metres_of(Name, Metres)
    ->  fault_at(At, "lengths in goals are in metres: write ~w for ~w", [Metres, Name], Fault)
    ;   Arity =:= 0
    ->  fault_at(At, "~q is no number~w", [Name, Hint], Fault)
    ;   value_of_word(Name, Asked)
    ->  fault_at(Position, "a goal gives the value, which is then computed with: ~w", [Asked], Fault)
    ;   fault_at(At, "~q is no function of arithmetic~w", [Name/Arity, Hint], Fault)
    ).
expression_fault(_, Position, Fault) :-
    fault_at(Position, "this is no number", [], Fault).

%   How the value that is named like a function is asked for.
value_of_word(Name, Asked) :-
    (   known_word(fact, Name/Arity)
    ->  signature(Name/Arity, Asked)
    ;   written_word(measure, Name, Written),
        format(string(Asked), "measure(~w, Value, Sd, Kind)", [Written])
    ).

summary_fault(Summary, Position, Fault) :-
    var(Summary),
    !,
    fault_at(Position, "aggregate_all needs to know what to work out: count, sum(X), ...", [],
             Fault).
summary_fault(Summary, Position, Fault) :-
    summed(Summary, Index),
    !,
    arg(Index, Summary, Expression),
    argument_position(Position, Index, At),
    expression_fault(Expression, At, Fault).
summary_fault(Summary, _, _) :-
    ( Summary == count ; Summary = bag(_) ; Summary = set(_) ),
    !,
    fail.
summary_fault(Summary, Position, Fault) :-
    compound(Summary),
    functor(Summary, Name, _),
    Sorts = [sum, max, min, bag, set, count],
    \+ memberchk(Name, Sorts),
    !,
    (   nearest(Name, Sorts, Nearest)
    ->  name_position(Position, At),
        fault_at(At, "aggregate_all works out no ~q; did you mean ~w?", [Name, Nearest], Fault)
    ;   arg(Index, Summary, Part),
        argument_position(Position, Index, At),
        summary_fault(Part, At, Fault)
    ).
summary_fault(_, Position, Fault) :-
    fault_at(Position,
             "aggregate_all works out count, sum(X), max(X), max(X, Of), min(...), bag(X), set(X)",
             [], Fault).

summed(sum(_), 1).
summed(max(_), 1).
summed(min(_), 1).
summed(max(_, _), 1).
summed(min(_, _), 1).
