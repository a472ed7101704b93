:- module(facetlog_partial, [ said_code/5,          % +Test, +Want, +Context, -Said, -Code
                              value_code/4,         % +Expression, +Context, -V, -Code
                              residual/5            % +Goal, +Module, +Context, +Seen, -Code
                            ]).

/** <module> Tests into goals, by partial evaluation

The clauses that say what a test means (say.pl, degrees.pl, compare.pl, quantities.pl) are run as far as
they can be without a scene; what is left of them is the goal. No test has a rule of its own here. What
is written is what these clauses would do, in their order:

  - a call of one of their predicates gives way to the body of the clause that matches, of which there is
    one;
  - static/1 is called now, and so is arithmetic on numbers that are known;
  - a loop over a list that is not known becomes a predicate of its own;
  - facts, measures and relations are asked as body_code.pl writes it.

What the clauses cannot decide without the scene, such as a test that is a variable, is left to them:
that part is said by say.pl each time. Context is as in specialise.pl.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(library(pairs)).
:- use_module(library(occurs)).
:- use_module(facetlog_kb(target)).
:- use_module(facetlog_kb(arithmetic)).
:- use_module(facetlog_kb(branches)).
:- use_module(facetlog_kb(loops)).
:- use_module(facetlog_kb(body_code)).
:- use_module(facetlog_kb(first_answer)).
:- use_module(facetlog_kb(say)).
:- use_module(facetlog_kb(plan)).

%   Where the clauses stand.
unfolded(facetlog_say).
unfolded(facetlog_degrees).
unfolded(facetlog_compare).
unfolded(facetlog_quantities).

%   Of these what goes on numbers or lists that only a scene has.
run_time(counted_together(_, _, _, _, _)).
run_time(joint_miss(_, _)).
run_time(total(_, _, _)).

%!  said_code(+Test, +Want, +Context, -Said, -Code) is det.
%
%   Code works out Said of Test, as said/4 does.
%
%   @throws facetlog_general(Test) if it asks for verdicts, which depend on what is being judged
%           (model_test.pl): such rules stay as they are.

said_code(Test, Want, Context, Said, Code) :-
    Context = context(Module, _, _),
    residual(said(Test, Module, Want, Said), facetlog_say, Context, Test-Said, Code).

%!  value_code(+Expression, +Context, -V, -Code) is det.
%
%   Code works out the value V, as value/3 does, or fails where the scene does not know.
%
%   @throws facetlog_unknown(What) if that cannot be seen beforehand.

value_code(Expression, Context, V, Code) :-
    Context = context(Module, _, _),
    residual(value(Expression, Module, quantity(V, _, _)), facetlog_quantities, Context,
             Expression-V, Code).

shape(state, said(_, none)).
shape(full, said(_, degree(_, _, _))).

                 /*******************************
                 *             GOALS            *
                 *******************************/

%!  residual(+Goal, +Module, +Context, +Seen, -Code) is det.
%
%   Code is what is left of Module:Goal. Seen has the variables that others see. It may bind variables of
%   Goal: what they are is known then.

residual(Goal, _, _, _, _) :-
    var(Goal),
    throw(facetlog_unknown(Goal)).
residual((A, B), Module, Context, Seen, Code) :-
    !,
    term_variables(B-Seen, SeenOfA),
    residual(A, Module, Context, SeenOfA, CodeA),
    (   CodeA == fail
    ->  Code = fail
    ;   shared(B, CodeA, Shared),
        term_variables(Shared-Seen, SeenOfB),
        residual(B, Module, Context, SeenOfB, CodeB),
        both(CodeA, CodeB, Code)
    ).
residual((If -> Then ; Else), Module, Context, Seen, Code) :-
    !,
    copy_term(Seen-If-Then, Seen1-If1-Then1),
    term_variables(Then1-Seen1, SeenOfIf),
    residual(If1, Module, Context, SeenOfIf, CodeIf),
    (   CodeIf == true
    ->  residual(If, Module, Context, Seen-Then, _),
        residual(Then, Module, Context, Seen, Code)
    ;   CodeIf == fail
    ->  residual(Else, Module, Context, Seen, Code)
    ;   copies(Seen, Seen1, CodeIf, Copies1),
        shared(Then1, CodeIf, Shared),
        term_variables(Shared-Seen1, SeenOfThen),
        residual(Then1, Module, Context, SeenOfThen, CodeThen0),
        bound_in_branch(Copies1, CodeThen0, CodeThen),
        copy_term(Seen-Else, Seen2-Else2),
        copies(Seen, Seen2, true, Copies2),
        residual(Else2, Module, Context, Seen2, CodeElse0),
        bound_in_branch(Copies2, CodeElse0, CodeElse),
        Code = ( CodeIf -> CodeThen ; CodeElse )
    ).
residual((A ; B), Module, Context, Seen, Code) :-
    !,
    residual(A, Module, Context, Seen, CodeA),
    (   CodeA == true
    ->  Code = true
    ;   residual(B, Module, Context, Seen, CodeB),
        either(CodeA, CodeB, Code)
    ).
residual(static(Goal), Module, _, _, Code) :-
    !,
    known_now(Module:Goal, Code).
residual(A = B, _, _, _, Code) :-
    !,
    ( A = B -> Code = true ; Code = fail ).
residual(A == B, _, _, _, Code) :-
    !,
    (   A == B
    ->  Code = true
    ;   A \= B
    ->  Code = fail
    ;   Code = ( A == B )
    ).
residual(crisp, _, context(_, _, Crisp), _, Code) :-
    !,
    ( Crisp == true -> Code = true ; Code = fail ).
residual(Goal, _, _, _, Code) :-
    arithmetic(Goal, Code0),
    !,
    Code = Code0.
residual(call(Goal), _, Context, _, Code) :-
    !,
    body_code(Goal, Context, Code).
residual(first_measure(Measure, V, Sd, Kind), _, Context, _, Code) :-
    !,
    first_answer_code(Measure, V, Sd, Kind, Context, Code).
residual(model_said(_, Thing, Model, _), _, _, _, _) :-
    throw(facetlog_general(is_a(Thing, Model))).
residual(own_measure(_, _, _, _, _), _, _, _, _) :-
    throw(facetlog_unknown(own_measure)).    % nobody knows its kind before
residual(said(Test, Module, Want, Said), facetlog_say, Context, Seen, Code) :-
    !,
    shape(Want, Said),
    (   attempt(Context, facetlog_unknown(_),
                said_residual(Test, Module, Want, Said, Context, Seen, Code0))
    ->  Code = Code0
    ;   asks_no_model(Test),
        asks_all(Context),
        Code = facetlog_say:said(Test, Module, Want, Said)
    ).
residual(Goal, Module, Context, _, Code) :-
    loop(Goal, Module, Context, Code0),
    !,
    Code = Code0.
residual(Goal, Module, Context, Seen, Code) :-
    defined_in(Goal, Module, Source),
    unfolded(Source),
    \+ run_time(Goal),
    !,
    shaped(Goal),
    findall(Goal-Body, clause(Source:Goal, Body), Matching),
    (   Matching == []
    ->  Code = fail
    ;   Matching = [Goal-Body]
    ->  residual(Body, Source, Context, Seen, Code)
    ;   throw(facetlog_unknown(Goal))
    ).
residual(Goal, Module, _, _, Code) :-
    placed(Goal, Module, Code).

%   What follows from the test alone; it must be there to follow from.
known_now(Module:Goal0, Code) :-
    strip_module(Module:Goal0, Source, Goal),
    arg(1, Goal, Test),
    (   nonvar(Test),
        catch(findall(Goal, once(Source:Goal), Found), error(_, _), fail)
    ->  ( Found = [Goal] -> Code = true ; Code = fail )
    ;   throw(facetlog_unknown(Goal))
    ).

                 /*******************************
                 *             TESTS            *
                 *******************************/

said_residual(Test0, Module, Want, Said, Context, Seen, Code) :-
    (   var(Test0)
    ->  throw(facetlog_unknown(Test0))
    ;   Test0 = after(Step, Test)       % what specialise.pl puts off
    ->  residual(said(Test, Module, Want, Said), facetlog_say, Context, Step-Seen, Code0),
        Code = ( Step, Code0 )
    ;   has_word(Module, Test0)
    ->  meaning_code(Test0, Module, Want, Said, Context, Code)
    ;   cheapest_first(Test0, Want, Test),
        known_now(facetlog_say:sort_of(Test, Module, Sort), _),
        residual(said_of(Sort, Test, Module, Want, Said), facetlog_say, Context, Seen, Code)
    ).

cheapest_first(Test0, Want, Test) :-
    (   in_any_order(Test0, Want, Tests0, Test1, Tests),
        is_list(Tests0)
    ->  maplist(test_cost, Tests0, Costs),
        pairs_keys_values(Pairs, Costs, Tests0),
        keysort(Pairs, Sorted),
        pairs_values(Sorted, Tests),
        Test = Test1
    ;   Test = Test0
    ).

%   What is said of Test0 is that of Test, whatever the order of its Tests. (A product of degrees would differ
%   in its last digit.)
in_any_order(any(Tests0), _, Tests0, any(Tests), Tests).
in_any_order(all(Tests0), state, Tests0, all(Tests), Tests).

asks_no_model(Test) :-
    (   sub_term(Model, Test),
        nonvar(Model),
        Model = is_a(_, _)
    ->  throw(facetlog_general(Model))
    ;   true
    ).

%   What a word of the rules says is remembered until the next scene.
meaning_code(Test, Module, Want, Said, Context, Code) :-
    (   meant(Module, Test, Meaning)
    ->  term_variables(Test, Args),
        remembered_code(word(Module, Test, Want), Args, Said,
                        said(Meaning, Module, Want, Said), facetlog_say, Context, Code)
    ;   throw(facetlog_unknown(Test))
    ).

%   Only a word whose meaning does not depend on what its arguments are.
meant(Module, Test, Meaning) :-
    current_predicate(Module:means/2),
    copy_term(Test, Copy),
    findall(Test-Meaning0, Module:means(Test, Meaning0), [Copy1-_|_]),
    Copy1 =@= Copy,
    once(Module:means(Test, Meaning)).

has_word(Module, Test) :-
    current_predicate(Module:means/2),
    \+ \+ Module:means(Test, _).

%   Code asks what Goal comes to for Args, once for each scene.
remembered_code(Key, Args, Said, Goal, Module, Context, Code) :-
    term_variables(Said, Answers),
    copy_term(Key-Args-Answers-Goal, Key1-Args1-Answers1-Goal1),
    append(Args1, Answers1, HeadArgs),
    helper(Context, Key1, HeadArgs, Head, New),
    (   New == true
    ->  residual(Goal1, Module, Context, HeadArgs, Body),
        put_remembered(Context, Head, Args1, Answers1, Body)
    ;   true
    ),
    append(Args, Answers, CallArgs),
    Head =.. [Name|_],
    Code =.. [Name|CallArgs].
