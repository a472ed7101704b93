:- module(facetlog_say, [ outline/3,        % +Test, +Module, -Outline
                          state/3,          % +Test, +Module, -State
                          said/4,           % +Test, +Module, +Want, -Said
                          sort_of/3,        % +Test, +Module, -Sort
                          left_open/1,      % +Parts
                          meaning/3,        % +Word, +Module, -Test
                          instance/4        % +Variables, +Test, +Values, -Instance
                        ]).

/** <module> What is said of a test

The one place where a test is worked out. A test is a term over the words of the vocabulary: a comparison
of measures (compare.pl), a relation, another model, a short word, or a form that joins other tests
(degrees.pl). Module may define words by means/2, measures by measured/4 and named tolerances by
tolerance/2.

The clauses here, in degrees.pl, compare.pl and quantities.pl are also what partial.pl specialises for the
tests of given models. For that each predicate has one clause for what its first argument can be, decides
by its arguments alone, and what follows from the test, and not from the scene, stands in static/1.
*/

:- use_module(library(lists)).
:- use_module(library(error)).
:- use_module(facetlog_kb(static)).
:- use_module(facetlog_kb(variables)).
:- use_module(facetlog_kb(degrees)).
:- use_module(facetlog_kb(compare)).
:- use_module(facetlog_kb(model_test)).
:- use_module(facetlog_kb(quantities)).
:- use_module(facetlog(vocabulary)).

:- set_prolog_flag(optimise, true).

%!  outline(+Test, +Module, -Outline) is det.
%
%   Outline is outline(State, Low, High, Miss) of Test in the current scene, see degrees.pl. What can
%   change none of these any more is not asked; the miss does not depend on the order of a test's parts.
%
%   @error existence_error(word, Name/Arity) if Test is not in the vocabulary.
%   @error type_error(comparable, Test) if a length is compared with a bare number, or the like.

outline(Test, Module, outline(State, Low, High, Miss)) :-
    said(Test, Module, full, said(State, degree(Low, High, Miss))).

%!  state(+Test, +Module, -State) is det.
%
%   The state alone, which asks no more of Test than decides it.
%
%   @error as outline/3

state(Test, Module, State) :-
    said(Test, Module, state, said(State, _)).

%!  said(+Test, +Module, +Want, -Said) is det.
%
%   What degrees.pl calls so; Want is `state` or `full`.
%
%   @error as outline/3

said(Test, Module, Want, Said) :-
    static(sort_of(Test, Module, Sort)),
    said_of(Sort, Test, Module, Want, Said).

said_of(comparison(Measure, Bounds), Test, Module, Want, Said) :-
    compared(Measure, Bounds, Module, Test, Want, Said).
said_of(joined(Join, Parts), _, Module, Want, Said) :-
    (   left_open(Parts)
    ->  plain(Want, unknown, Said)
    ;   start(Join, Want, Sum0),
        ask(Parts, Join, Module, Want, Sum0, Sum),
        together(Join, Want, Sum, Said)
    ).
said_of(relation, Relation, _, Want, Said) :-
    static(vocabulary:truth(Relation, For, Against)),
    (   call(vocabulary:For)
    ->  plain(Want, holds, Said)
    ;   call(vocabulary:Against)
    ->  plain(Want, fails, Said)
    ;   plain(Want, unknown, Said)
    ).
said_of(is_a(Thing, Model), _, _, Want, Said) :-
    model_said(Want, Thing, Model, Said).
said_of(meaning(Meaning), _, Module, Want, Said) :-
    said(Meaning, Module, Want, Said).

model_said(state, Thing, Model, said(State, none)) :-
    model_state(Thing, Model, State).
model_said(full, Thing, Model, said(State, degree(Low, High, Miss))) :-
    model_outcome(Thing, Model, outcome(State, Low, High, _)),
    ( State == fails -> Miss = 1 ; Miss = 0 ).

%!  sort_of(+Test, +Module, -Sort) is det.
%
%   Sort is comparison(Measure, Bounds), joined(Join, Parts), relation, is_a(Thing, Model) or
%   meaning(Test).
%
%   @error as outline/3

sort_of(Test, Module, Sort) :-
    (   var(Test)
    ->  instantiation_error(Test)
    ;   comparison(Test, Measure, Bounds)
    ->  Sort = comparison(Measure, Bounds)
    ;   form(Test, Join, Parts, _)
    ->  Sort = joined(Join, Parts)
    ;   known_relation(Test)
    ->  Sort = relation
    ;   Test = is_a(Thing, Model)
    ->  Sort = is_a(Thing, Model)
    ;   meaning(Test, Module, Meaning)
    ->  Sort = meaning(Meaning)
    ;   functor(Test, Name, Arity),
        existence_error(word, Name/Arity)
    ).

%!  meaning(+Word, +Module, -Test) is semidet.
%
%   Word is short for Test.

meaning(Word, Module, Test) :-
    current_predicate(Module:means/2),
    Module:means(Word, Test),
    !.
meaning(Word, _, Test) :-
    vocabulary:means(Word, Test),
    !.

                 /*******************************
                 *             PARTS            *
                 *******************************/

%!  left_open(+Parts) is semidet.
%
%   There is nothing to choose from, and the test asks for a part that was not seen: who knows what
%   there is beside that?

left_open(over(Variables, List, Test)) :-
    List == [],
    static(names_beside(Variables, Test, Names)),
    any_unseen(Names).
left_open(groups(Variable, Groups, Test)) :-
    Groups == [],
    static(names_beside([Variable], Test, Names)),
    any_unseen(Names).

left_open(closed(_, Parts)) :-
    left_open(Parts).

any_unseen([Name|Names]) :-
    (   Name == unseen
    ->  true
    ;   any_unseen(Names)
    ).

%   What Test names beside Variables, or may name.
names_beside(Variables, Test, Names) :-
    term_variables(Variables, Locals),
    names_in(Locals, Test, Names).

names_in(Variables, Test, Names) :-
    (   var(Test)
    ->  ( among(Variables, Test) -> Names = [] ; Names = [Test] )
    ;   compound(Test)
    ->  Test =.. [_|Args],
        names_in_all(Args, Variables, Names)
    ;   Names = [Test]
    ).

names_in_all([], _, []).
names_in_all([Arg|Args], Variables, Names) :-
    names_in(Variables, Arg, Names0),
    names_in_all(Args, Variables, Names1),
    append(Names0, Names1, Names).

%   ask(Parts, Join, Module, Want, Sum0, Sum)
ask(tests(Tests), Join, Module, Want, Sum0, Sum) :-
    each_test(Tests, Join, Module, Want, Sum0, Sum).
ask(over(Variables, List, Test), Join, Module, Want, Sum0, Sum) :-
    ask_over(Variables, List, Test, Join, Module, Want, Sum0, Sum).
ask(groups(X, Groups, Test), Join, Module, Want, Sum0, Sum) :-
    must_be(list(list), Groups),
    each_group(Groups, X, Test, Join, Module, Want, Sum0, Sum).

ask(closed(Closed, Parts), Join, Module, Want, Sum0, Sum) :-
    said(Closed, Module, Want, Said),
    joined(Join, Want, Sum0, Said, Sum1),
    ask(Parts, Join, Module, Want, Sum1, Sum).

ask_over([X], List, Test, Join, Module, Want, Sum0, Sum) :-
    each_of(List, X, Test, Join, Module, Want, Sum0, Sum).
ask_over([X, Y], List, Test, Join, Module, Want, Sum0, Sum) :-
    each_pair_of(List, X, Y, Test, Join, Module, Want, Sum0, Sum).

each_test([], _, _, _, Sum, Sum).
each_test([Test|Tests], Join, Module, Want, Sum0, Sum) :-
    (   settled(Join, Want, Sum0)
    ->  Sum = Sum0
    ;   said(Test, Module, Want, Said),
        joined(Join, Want, Sum0, Said, Sum1),
        each_test(Tests, Join, Module, Want, Sum1, Sum)
    ).

each_of([], _, _, _, _, _, Sum, Sum).
each_of([Value|Values], X, Test, Join, Module, Want, Sum0, Sum) :-
    (   settled(Join, Want, Sum0)
    ->  Sum = Sum0
    ;   static(instance([X], Test, [Value], One)),
        said(One, Module, Want, Said),
        joined(Join, Want, Sum0, Said, Sum1),
        each_of(Values, X, Test, Join, Module, Want, Sum1, Sum)
    ).

each_pair_of([], _, _, _, _, _, _, Sum, Sum).
each_pair_of([Value|Values], X, Y, Test, Join, Module, Want, Sum0, Sum) :-
    each_with(Values, Value, X, Y, Test, Join, Module, Want, Sum0, Sum1),
    each_pair_of(Values, X, Y, Test, Join, Module, Want, Sum1, Sum).

each_with([], _, _, _, _, _, _, _, Sum, Sum).
each_with([Other|Others], Value, X, Y, Test, Join, Module, Want, Sum0, Sum) :-
    (   settled(Join, Want, Sum0)
    ->  Sum = Sum0
    ;   static(instance([X, Y], Test, [Value, Other], One)),
        said(One, Module, Want, Said),
        joined(Join, Want, Sum0, Said, Sum1),
        each_with(Others, Value, X, Y, Test, Join, Module, Want, Sum1, Sum)
    ).

each_group([], _, _, _, _, _, Sum, Sum).
each_group([Members|Groups], X, Test, Join, Module, Want, Sum0, Sum) :-
    start(any, Want, Best0),
    each_of(Members, X, Test, any, Module, Want, Best0, Best),
    together(any, Want, Best, Said),
    joined(Join, Want, Sum0, Said, Sum1),
    each_group(Groups, X, Test, Join, Module, Want, Sum1, Sum).

%!  instance(+Variables, +Test, +Values, -Instance) is det.
%
%   Instance is Test with Values in the place of Variables; others stay what they are.

instance(Variables, Test, Values, Instance) :-
    term_variables(Variables, Locals),  % one may be a pattern, as of an object and its parts
    term_variables(Test, All),
    others(All, Locals, Kept),
    copy_term(Variables-Kept-Test, Values-Kept-Instance).

others([], _, []).
others([Variable|All], Variables, Kept) :-
    (   among(Variables, Variable)
    ->  Kept = Kept1
    ;   Kept = [Variable|Kept1]
    ),
    others(All, Variables, Kept1).
