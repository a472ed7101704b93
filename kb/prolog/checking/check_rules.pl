:- module(facetlog_check_rules, [ scope_of/2,          % +Clauses, -Scope
                                  rules_faults/3,      % +Clauses, +Most, -Faults
                                  rules_warnings/2     % +Clauses, -Warnings
                                ]).

/** <module> What is wrong with a file of rules

Clauses are clause(Term, Position, Singletons) as read_rules/3 gives them; a fault is
fault(Start, End, Format, Args).
*/

:- use_module(library(lists)).
:- use_module(library(solution_sequences)).
:- use_module(facetlog_kb(positions)).
:- use_module(facetlog_kb(spelling)).
:- use_module(facetlog_kb(white_list)).
:- use_module(facetlog_kb(words)).
:- use_module(facetlog_kb(check)).
:- use_module(facetlog_kb(check_tests)).
:- use_module(facetlog_kb(rule_module)).

%!  rules_faults(+Clauses, +Most, -Faults) is det.
%
%   Faults are the first of them: to look for what was meant by each of thousands takes too long.

rules_faults(Clauses, Most, Faults) :-
    scope_of(Clauses, Scope),
    models_of(Clauses, Models),
    findall(Fault,
            limit(Most, ( file_fault(Clauses, Models, Fault)
                        ; member(Clause, Clauses),
                          clause_fault(Clause, Scope, Models, Fault) )),
            Faults).

%!  rules_warnings(+Clauses, -Warnings) is det.
%
%   Variables that stand once in a clause: a slip of the pen, or they would be written _.

rules_warnings(Clauses, Warnings) :-
    findall(fault(Start, End, "the variable ~w stands here only: write _~w if that is meant",
                  [Name, Name]),
            ( member(clause(_, Position, Singletons), Clauses),
              member(Name=_, Singletons),
              \+ sub_atom(Name, 0, _, _, '_'),
              span(Position, Start, End) ),
            Warnings).

%!  scope_of(+Clauses, -Scope) is det.
%
%   Scope is what the clauses define, for goal_fault/4 and prepared/4.

scope_of(Clauses, scope(rules, Own, Words, Tolerances)) :-
    findall(Name/Arity, ( head_among(Clauses, Head, _), functor(Head, Name, Arity) ), Own0),
    sort(Own0, Own),
    findall(Word,
            ( head_among(Clauses, means(Word0, _), _),
              callable(Word0),
              functor(Word0, Name, Arity),
              functor(Word, Name, Arity) ),
            Words),
    findall(Name, ( head_among(Clauses, tolerance(Name, _), _), atom(Name) ), Tolerances).

models_of(Clauses, Models) :-
    findall(Name-Roles, ( head_among(Clauses, model(Name, _, Roles), _), atom(Name) ), Models).

head_among(Clauses, Head, Position) :-
    member(clause(Term, Whole, _), Clauses),
    head_of(Term, Whole, Head0, Position),
    callable(Head0),
    Head = Head0.

head_of((:- _), _, _, _) :- !, fail.
head_of((Head :- _), Whole, Head, Position) :-
    !,
    argument_position(Whole, 1, Position).
head_of(Head, Position, Head, Position).

                 /*******************************
                 *            CLAUSES           *
                 *******************************/

clause_fault(clause(Term, Position, _), Scope, Models, fault(Start, End, Format, Args)) :-
    (   Term = (:- Directive)
    ->  directive_fault(Directive, Format, Args),
        span(Position, Start, End)
    ;   Term = (Head :- Body)
    ->  argument_position(Position, 1, HeadPosition),
        (   head_fault(Head, HeadPosition, Scope, Models, fault(Start, End, Format, Args))
        ;   Head = model(_, _, _),
            % It is asked when the file is loaded, without limits.
            fault_at(HeadPosition, "a model is a fact, and has no body", [],
                     fault(Start, End, Format, Args))
        ;   argument_position(Position, 2, BodyPosition),
            goal_fault(Body, BodyPosition, Scope, fault(Start, End, Format, Args))
        )
    ;   head_fault(Term, Position, Scope, Models, fault(Start, End, Format, Args))
    ).

directive_fault(Directive, Format, [Shown]) :-
    \+ plain_directive(Directive),
    string_concat("the directive ~q is refused: a model file begins with :- module(Name, []) and ",
                  ":- use_module(facetlog(vocabulary)), and has no others", Format),
    (   callable(Directive)
    ->  functor(Directive, Name, Arity),
        Shown = Name/Arity
    ;   Shown = (:-)
    ).

plain_directive(Directive) :-
    nonvar(Directive),
    (   Directive = module(Name, Exports),
        atom(Name),
        is_list(Exports)
    ;   ground(Directive),
        Directive = use_module(File),
        memberchk(File, [facetlog(vocabulary), library(lists), library(apply),
                         library(aggregate), library(solution_sequences), library(pairs)])
    ).

head_fault(Head, Position, _, _, Fault) :-
    (   \+ callable(Head)
    ;   functor(Head, Name, Arity),
        memberchk(Name/Arity, [(:)/2, (-->)/2, (?-)/1, (:-)/1, (:-)/2, (=>)/2, (',')/2, ('|')/2])
    ),
    !,
    fault_at(Position, "this is no rule: a rule is a head, or Head :- Body", [], Fault).
head_fault(Head, Position, _, _, Fault) :-
    functor(Head, Name, Arity),
    defined_elsewhere(Name/Arity, Whose),
    !,
    name_position(Position, At),
    fault_at(At, "~q is ~w and cannot be defined anew", [Name/Arity, Whose], Fault).
head_fault(Head, Position, _, _, Fault) :-
    functor(Head, Name, Arity),
    protocol(Name, Right),
    \+ protocol(Name, Arity),
    !,
    name_position(Position, At),
    fault_at(At, "~w has ~d arguments, not ~d; see docs/models.md", [Name, Right, Arity], Fault).
head_fault(Head, Position, Scope, Models, Fault) :-
    clause_of_model(Head, Position, Scope, Models, Fault).

defined_elsewhere(Indicator, "a word of the vocabulary") :-
    ( search_word(Indicator) ; Indicator = fact/1 ),
    !.
defined_elsewhere(Name/Arity, "a fact of scenes") :-
    functor(Head, Name, Arity),
    fact_word(Head),
    !.
defined_elsewhere(Indicator, "Prolog's own") :-
    ( reserved(Indicator) ; support_word(_, Indicator) ),
    !.

                 /*******************************
                 *            MODELS            *
                 *******************************/

protocol(model, 3).
protocol(candidate, 3).
protocol(condition, 6).
protocol(size, 5).
protocol(tolerance, 2).
protocol(means, 2).

%   The clauses that docs/models.md describes, each by its own rules.
clause_of_model(model(Name, Text, Roles), Position, _, _, Fault) :-
    (   \+ atom(Name),
        said_of(Position, 1, "a model's name is a small word: box", Fault)
    ;   \+ ( string(Text) ; atom(Text) ),
        said_of(Position, 2, "what a model is, is said as a text: \"A level board.\"", Fault)
    ;   \+ ( is_list(Roles), Roles \== [], forall(member(Role, Roles), atom(Role)) ),
        said_of(Position, 3, "a model names its parts: [seat, back]", Fault)
    ).
clause_of_model(candidate(Name, _, Parts), Position, _, Models, Fault) :-
    (   not_a_model(Name, Position, 1, Models, Fault)
    ;   parts_fault(Name, Parts, Position, 3, Models, Fault)
    ).
clause_of_model(condition(Name, Label, Reason, _, Parts, Test), Position, Scope, Models, Fault) :-
    (   not_a_model(Name, Position, 1, Models, Fault)
    ;   nonvar(Label),
        \+ atom(Label),
        said_of(Position, 2, "a condition's label is a small word", Fault)
    ;   nonvar(Reason),
        \+ string(Reason),
        \+ atom(Reason),
        said_of(Position, 3, "a condition's reason is a text: \"it lies level\"", Fault)
    ;   parts_fault(Name, Parts, Position, 5, Models, Fault)
    ;   argument_position(Position, 6, At),
        test_fault(Test, At, Scope, Fault)
    ).
clause_of_model(size(Name, _, Parts, _, Measure), Position, Scope, Models, Fault) :-
    (   not_a_model(Name, Position, 1, Models, Fault)
    ;   parts_fault(Name, Parts, Position, 3, Models, Fault)
    ;   argument_position(Position, 5, At),
        measure_fault(Measure, At, Scope, Fault)
    ).
clause_of_model(tolerance(Name, Value), Position, _, _, Fault) :-
    (   \+ atom(Name),
        said_of(Position, 1, "a tolerance's name is a small word", Fault)
    ;   nonvar(Value),
        \+ number(Value),
        said_of(Position, 2, "a tolerance is a number", Fault)
    ).
clause_of_model(means(Word, Test), Position, Scope, _, Fault) :-
    (   \+ callable(Word),
        said_of(Position, 1, "means/2 says what a word stands for: means(flat(X), Test)", Fault)
    ;   callable(Word),
        defined_test(Word, Format, Args),
        argument_position(Position, 1, At0),
        name_position(At0, At),
        fault_at(At, Format, Args, Fault)
    ;   argument_position(Position, 2, At),
        test_fault(Test, At, Scope, Fault)
    ).

said_of(Position, Index, Format, Fault) :-
    argument_position(Position, Index, At),
    fault_at(At, Format, [], Fault).

%   The vocabulary's connectives, comparisons and relations come first: the clause would be in vain.
defined_test(Word, "~q is a word of the vocabulary and cannot be defined anew", [Name/Arity]) :-
    functor(Word, Name, Arity),
    functor(General, Name, Arity),
    (   test_form(General, _)
    ;   known_word(relation, Name/Arity),
        \+ vocabulary:derived_word(General)
    ),
    !.

not_a_model(Name, Position, Index, Models, Fault) :-
    nonvar(Name),
    \+ memberchk(Name-_, Models),
    argument_position(Position, Index, At),
    (   atom(Name)
    ->  findall(Known, member(Known-_, Models), Names),
        hint(Name, Names, Hint),
        fault_at(At, "~q is no model of this file~w", [Name, Hint], Fault)
    ;   fault_at(At, "a model's name is a small word: box", [], Fault)
    ).

parts_fault(Name, Parts, Position, Index, Models, Fault) :-
    atom(Name),
    member(Name-Roles, Models),
    is_list(Roles),
    nonvar(Parts),
    argument_position(Position, Index, At),
    (   is_list(Parts)
    ->  length(Roles, Wanted),
        length(Parts, Given),
        Wanted =\= Given,
        fault_at(At, "the parts of the model ~w are ~w: ~d, not ~d", [Name, Roles, Wanted, Given],
                 Fault)
    ;   \+ Parts = [_|_],
        fault_at(At, "the parts of a model stand in a list: [Seat, Back]", [], Fault)
    ),
    !.

%   Every model says what it looks for, among what, and by which conditions.
file_fault(_, [], fault(0, 0, "a model needs ~w; see docs/models.md", [model/3])).
file_fault(Clauses, Models, fault(Start, End, "the model ~w needs ~w; see docs/models.md",
                                  [Name, Needed])) :-
    member(Name-_, Models),
    member(Needed, [candidate/3, condition/6]),
    \+ defines(Clauses, Needed, Name),
    once(( head_among(Clauses, model(Name0, _, _), Position), Name0 == Name )),
    span(Position, Start, End).
file_fault(Clauses, Models, fault(Start, End, "the model ~w is defined twice", [Name])) :-
    select(Name-_, Models, Others),
    memberchk(Name-_, Others),
    findall(Position,
            ( head_among(Clauses, model(Name0, _, _), Position), Name0 == Name ),
            [First|_]),
    span(First, Start, End),
    !.

%   A clause for a model that is still a variable may be for each.
defines(Clauses, Needed/Arity, Name) :-
    head_among(Clauses, Head, _),
    functor(Head, Needed, Arity),
    arg(1, Head, Of),
    ( var(Of) ; Of == Name ),
    !.
