:- module(facetlog_state_code, [ state_code/4          % +Wanted, +Test, +Context, -Code
                              ]).

/** <module> Tests into goals that say whether

What evaluate.pl finds out of a test by looking at it each time is here found out once, when the goal
is written. A test that cannot be seen through, such as one that is a variable, is left to evaluate.pl.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(facetlog_kb(target)).
:- use_module(facetlog_kb(measure_code)).
:- use_module(facetlog_kb(seen_through)).
:- use_module(facetlog_kb(sources)).
:- use_module(facetlog_kb(compare)).
:- use_module(facetlog_kb(evaluate)).
:- use_module(facetlog_kb(outlines)).
:- use_module(facetlog(vocabulary)).

%!  state_code(+Wanted, +Test, +Context, -Code) is det.
%
%   Code succeeds, once, if Test holds (Wanted is `holds`) or does not fail (`possible`).

state_code(Wanted, Test, Context, Code) :-
    (   nonvar(Test),
        state_of(Test, Wanted, Context, Code0)
    ->  Code = Code0
    ;   Context = context(Module, _, _),
        no_models(Test),
        asks_all(Context),
        Code = facetlog_evaluate:Asked,
        Goal = state(Test, Module, State),
        ( Wanted == holds -> State = holds, Asked = Goal ; Asked = ( Goal, State \== fails ) )
    ).

state_of(Test, Wanted, Context, Code) :-
    comparison(Test, Measure, Bounds),
    !,
    comparison_code(Measure, Bounds, Context, Known, Margins),
    inside_code(Margins, Measure, Wanted, Inside),
    (   Wanted == holds
    ->  Code = ( Known -> Inside ; fail )
    ;   Code = ( Known -> Inside ; true )
    ).
state_of(all(Tests), Wanted, Context, Code) :-
    is_list(Tests),
    !,
    maplist(state_in(Wanted, Context), Tests, Codes),
    conjunction(Codes, Code).
state_of(any(Tests), Wanted, Context, Code) :-
    is_list(Tests),
    !,
    maplist(state_in(Wanted, Context), Tests, Codes),
    disjunction(Codes, Code).
state_of(not(Test), Wanted, Context, \+ Code) :-
    !,
    other(Wanted, Other),
    state_code(Other, Test, Context, Code).
state_of(after(Steps, Test, Scope), Wanted, Context, Code) :-
    !,                                  % what line_code.pl puts off
    maplist(step_code(Scope, Context), Steps, Codes),
    state_code(Wanted, Test, Context, Code0),
    append(Codes, [Code0], All),
    conjunction(All, Code).
state_of(if_known(Test), _, Context, Code) :-
    !,
    state_code(possible, Test, Context, Code).
state_of(implies(Where, Test), Wanted, Context, ( If -> Then ; true )) :-
    !,
    other(Wanted, Other),
    state_code(Other, Where, Context, If),
    state_code(Wanted, Test, Context, Then).
state_of(expect(_, _), _, _, true) :- !.
state_of(Test, Wanted, Context, Code) :-
    written_out(Test, Plain),
    !,
    state_code(Wanted, Plain, Context, Code).
state_of(each(X, List, Test), Wanted, Context, \+ ( Member, \+ Code )) :-
    !,
    one_of(X, List, Test, Fresh, Member),
    state_code(Wanted, Fresh, Context, Code).
state_of(some(X, List, Test), Wanted, Context, \+ \+ ( Member, Code )) :-
    !,
    one_of(X, List, Test, Fresh, Member),
    state_code(Wanted, Fresh, Context, Code).
state_of(each_pair(X, Y, List, Test), Wanted, Context, \+ ( Pair, \+ Code )) :-
    !,
    two_of(X, Y, List, Test, Fresh, Pair),
    state_code(Wanted, Fresh, Context, Code).
state_of(Test, Wanted, Context, Code) :-
    known_relation(Test),
    !,
    relation_code(Test, Context, Truth),
    relation_state(Truth, Wanted, Code).
state_of(Test, Wanted, Context, Code) :-
    meaning_of(Test, Context, Sort, Meaning),
    (   Sort == own
    ->  word_state(Test, Wanted, Context, Meaning, Code)
    ;   state_code(Wanted, Meaning, Context, Code)
    ).

state_in(Wanted, Context, Test, Code) :-
    state_code(Wanted, Test, Context, Code).

other(holds, possible).
other(possible, holds).

word_state(Test, Wanted, Context, Meaning, Code) :-
    term_variables(Test, Args),
    copy_term(Args-Test-Meaning, HeadArgs-HeadTest-HeadMeaning),
    Context = context(Module, _, _),
    helper(Context, word(Wanted, Module, HeadTest), HeadArgs, Head, New),
    (   New == true
    ->  state_code(Wanted, HeadMeaning, Context, Body),
        put_remembered(Context, Head, HeadArgs, [], Body)
    ;   true
    ),
    Head =.. [Name|_],
    Code =.. [Name|Args].

                 /*******************************
                 *          COMPARISONS         *
                 *******************************/

%   Outside it fails, unless more of what is counted may be there.
inside_code(one(below, _, _, _), Measure, possible, Code) :-
    so_far_measure(Measure),
    !,
    Code = true.
inside_code(one(_, D, _, _), _, _, D >= 0) :- !.
inside_code(two(B, BV, A, AV, _), _, holds, Code) :-
    !,
    Code = ( B >= 0, A >= 0, facetlog_outlines:mostly_inside(B, BV, A, AV) ).
inside_code(two(B, _, A, _, _), Measure, possible, Code) :-
    !,
    (   so_far_measure(Measure)
    ->  Code = ( A >= 0 -> true ; B =< A )
    ;   Code = ( B >= 0, A >= 0 )
    ).
inside_code(Margins, Measure, Wanted, Code) :-
    compared_code(Margins, Measure, Compared, outline(State, _, _, _)),
    ( Wanted == holds -> Code = ( Compared, State == holds )
    ; Code = ( Compared, State \== fails ) ).

relation_state(settled(Code, _), holds, ( Code -> true ; fail )).
relation_state(settled(Code, Unseen), possible, ( Code -> true ; Unseen )).
relation_state(either(For, _), holds, ( For -> true ; fail )).
relation_state(either(For, Against), possible, ( For -> true ; \+ Against )).
