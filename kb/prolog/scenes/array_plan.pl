:- module(facetlog_array_plan, [ array_plan/4       % +Goal, +Vars, +Scope, -Plan
                               ]).

/** <module> Questions that need no search: what is to be looked up in columns of facts

Facts alone, compared and joined, and faces of which each two pass a test are answered from arrays in Python
(kb/arrays/), with the same rows
in the same order as Prolog finds them. A plan is

    plan(Columns, Steps, Facts)

of the numbers of the variables that are asked for, of what to do one after the other, and of the
facts, Name/Arity, that it looks up. Variables are variable(Number). A step is

  - fact(Name, Args): a row of the fact for each, where an argument is a variable or
    constant(Value);
  - compare(Op, A, B): the values of two expressions of numbers and variables;
  - order(Op, A, B): the standard order of two names, each a variable or constant(Name);
  - absent(Steps): there is none;
  - pairs(Faces, Text, Way): each two of Faces, variables or constant(Name), pass the test of Text,
    pair(X, Y, Test). Way is `graph`, or measured(Name, Arity, A, B, Value, Sd, Bounds) where one fact says
    which do: the places of its arguments from 0, and what the value is compared with;
  - summed(Summary, Number, Steps): the variable Number is count, sum(Number), max(Number) or
    min(Number) of all.

Whatever is none of these has no plan, and is Prolog's: so are all errors.
*/

:- use_module(library(lists)).
:- use_module(library(assoc)).
:- use_module(library(apply)).
:- use_module(facetlog_kb(prepare)).
:- use_module(facetlog_kb(pairs)).

%!  array_plan(+Goal, +Vars, +Scope, -Plan) is semidet.
%
%   Plan is that of Goal, in which goal_fault/4 (check.pl) finds no fault, for the values of Vars.

array_plan(Goal, Vars, Scope, plan(Columns, Steps, Facts)) :-
    term_variables(Goal, All),
    planned(Goal, context(All, Scope), [], Bound, Steps, [], Facts0),
    \+ found_by_index(Steps),
    deepest(Deepest),
    no_deeper(Deepest, Steps),
    sort(Facts0, Facts),
    Facts = [_|_],
    maplist(bound_number(All, Bound), Vars, Columns).

%   One fact of a known name: Prolog goes there at once, arrays look at all of them.
found_by_index([fact(_, Args)|Tests]) :-
    member(constant(Name), Args),
    atom(Name),
    forall(member(Test, Tests), ( Test = compare(_, _, _) ; Test = order(_, _, _) )),
    !.

%   Levels of a plan; Python reads and follows it by recursion.
deepest(40).

no_deeper(_, Term) :- atomic(Term), !.
no_deeper(Levels, [Term|Terms]) :-
    !,
    no_deeper(Levels, Term),
    no_deeper(Levels, Terms).
no_deeper(Levels, Term) :-
    Levels > 0,
    Fewer is Levels - 1,
    compound_name_arguments(Term, _, Args),
    no_deeper(Fewer, Args).

bound_number(All, Bound, Variable, Number) :-
    number_of(All, 1, Variable, Number),
    memberchk(Number, Bound).

number_of([Other|All], Number0, Variable, Number) :-
    (   Other == Variable
    ->  Number = Number0
    ;   Number1 is Number0 + 1,
        number_of(All, Number1, Variable, Number)
    ).

%   planned(Goal, Context, Bound0, Bound, Steps, Tail, Facts): Bound are the numbers of the variables
%   that have a value after Goal. The list of Facts has all that are looked up, with repetitions.
planned(Goal, Context, Bound0, Bound, Steps, Facts0, Facts) :-
    nonvar(Goal),
    (   Goal = (A, B)
    ->  planned(A, Context, Bound0, Bound1, Before, Facts0, Facts1),
        planned(B, Context, Bound1, Bound, After, Facts1, Facts),
        append(Before, After, Steps)
    ;   \+ own_word(Goal, Context),
        step(Goal, Context, Bound0, Bound, Step, Facts0, Facts),
        Steps = [Step]
    ).

own_word(Goal, context(_, scope(_, Own, _, _, _))) :-
    functor(Goal, Name, Arity),
    get_assoc(Name/Arity, Own, _).

step(\+ Goal, Context, Bound, Bound, absent(Steps), Facts0, Facts) :-
    !,
    planned(Goal, Context, Bound, _, Steps, Facts0, Facts).
step(aggregate_all(What, Goal, Result), Context, [], [Number], summed(Summary, Number, Steps),
     Facts0, Facts) :-
    !,
    % In front of all others: there is one result, whatever else is asked.
    Context = context(All, _),
    var(Result),
    term_variables(What-Goal, Inner),
    \+ number_of(Inner, 1, Result, _),
    number_of(All, 1, Result, Number),
    planned(Goal, Context, [], Bound, Steps, Facts0, Facts),
    summary(What, All, Bound, Summary).
step(each_pair(X, Y, Faces0, Test), context(All, _), [], Bound, pairs(Faces, Text, Way),
     Facts, [face/1, evidence/2|Facts1]) :-
    !,
    is_list(Faces0),
    Faces0 = [_|_],
    var(X), var(Y), X \== Y,
    term_variables(Faces0, Variables),
    length(Variables, Count),
    foldl(argument(All), Faces0, Faces, [], Bound),
    length(Bound, Count),
    include(var, Faces0, Unbound),
    length(Unbound, Count),                 % none twice
    \+ ( member(Variable, Variables), ( Variable == X ; Variable == Y ) ),
    term_variables(X-Y-Test, [_, _]),
    format(string(Text), "~W",
           [ pair(X, Y, Test),
             [ quoted(true), ignore_ops(true), numbervars(false),
               variable_names(['X'=X, 'Y'=Y]) ] ]),
    pairs_by(X, Y, Test, Way, Facts, Facts1).
step(Goal, Context, Bound, Bound, compare(Op, A, B), Facts, Facts) :-
    compares(Goal, Op, A0, B0),
    !,
    expression(A0, Context, Bound, A),
    expression(B0, Context, Bound, B).
step(Goal, Context, Bound, Bound, order(Op, A, B), Facts, Facts) :-
    orders(Goal, Op, A0, B0),
    !,
    name(A0, Context, Bound, A),
    name(B0, Context, Bound, B).
step(Goal, Context, Bound0, Bound, fact(Name, Args), Facts, [Name/Arity|Facts]) :-
    Context = context(All, Scope),
    prepared(Goal, Scope, facetlog_query, Runnable),
    Runnable = fact(Fact),
    Fact == Goal,
    compound(Goal),
    compound_name_arguments(Goal, Name, Args0),
    length(Args0, Arity),
    foldl(argument(All), Args0, Args, Bound0, Bound).

pairs_by(X, Y, Test, measured(Name, Arity, A, B, V, S, Bounds), Facts, [Name/Arity|Facts]) :-
    measured_pairs(X, Y, Test, Fact, Value, Sd, _, Bounds),
    compound_name_arguments(Bounds, Form, Limits),
    memberchk(Form, [near, between, at_least, at_most]),
    maplist(plain_number, Limits),
    compound_name_arguments(Fact, Name, Args),
    length(Args, Arity),
    maplist(place_of(Args), [X, Y, Value, Sd], [A, B, V, S]),
    !.
pairs_by(_, _, _, graph, Facts, Facts).

place_of(Args, Variable, Place) :-
    var(Variable),
    nth0(Place, Args, Arg),
    Arg == Variable,
    !.

argument(All, Argument, variable(Number), Bound0, Bound) :-
    var(Argument),
    !,
    number_of(All, 1, Argument, Number),
    ( memberchk(Number, Bound0) -> Bound = Bound0 ; Bound = [Number|Bound0] ).
argument(_, Argument, constant(Argument), Bound, Bound) :-
    plain_constant(Argument).

plain_constant(X) :- atom(X), !, X \== [].
plain_constant(X) :- plain_number(X).

plain_number(X) :- integer(X), !, abs(X) =< 0x20000000000000.      % a float is as exact
plain_number(X) :- float(X), abs(X) < inf.

summary(What, _, _, count) :-
    What == count.
summary(What, All, Bound, Summary) :-
    compound(What),
    What =.. [Name, Variable],
    memberchk(Name, [sum, max, min]),
    var(Variable),
    bound_number(All, Bound, Variable, Number),
    Summary =.. [Name, Number].

compares(A < B, <, A, B).
compares(A > B, >, A, B).
compares(A =< B, =<, A, B).
compares(A >= B, >=, A, B).
compares(A =:= B, =:=, A, B).
compares(A =\= B, =\=, A, B).

orders(A @< B, @<, A, B).
orders(A @> B, @>, A, B).
orders(A @=< B, @=<, A, B).
orders(A @>= B, @>=, A, B).
orders(A == B, ==, A, B).
orders(A \== B, \==, A, B).

%   Numbers, variables with a value, and what IEEE 754 gives one result.
expression(Variable, context(All, _), Bound, variable(Number)) :-
    var(Variable),
    !,
    bound_number(All, Bound, Variable, Number).
expression(Value, _, _, constant(Value)) :-
    number(Value),
    !,
    plain_number(Value).
expression(Term, Context, Bound, Expression) :-
    compound(Term),
    compound_name_arguments(Term, Op, Args0),
    length(Args0, Arity),
    memberchk(Op/Arity, [(+)/2, (-)/2, (*)/2, (/)/2, (-)/1, abs/1]),
    expressions(Args0, Context, Bound, Args),
    compound_name_arguments(Expression, Op, Args).

expressions([], _, _, []).
expressions([Term|Terms], Context, Bound, [Expression|Expressions]) :-
    expression(Term, Context, Bound, Expression),
    expressions(Terms, Context, Bound, Expressions).

name(Variable, context(All, _), Bound, variable(Number)) :-
    var(Variable),
    !,
    bound_number(All, Bound, Variable, Number).
name(Name, _, _, constant(Name)) :-
    atom(Name),
    Name \== [].
