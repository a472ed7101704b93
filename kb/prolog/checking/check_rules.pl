:- module(facetlog_check_rules, [ scope_of/2,          % +Clauses, -Scope
                                  rules_faults/3,      % +Clauses, +Most, -Faults
                                  rules_warnings/2     % +Clauses, -Warnings
                                ]).

/** <module> What is wrong with a file of rules

Clauses are clause(Term, Position, Singletons) as read_rules/3 gives them; a fault is
fault(Start, End, Format, Args).
*/

:- use_module(library(assoc)).
:- use_module(library(lists)).
:- use_module(library(solution_sequences)).
:- use_module(facetlog_kb(positions)).
:- use_module(facetlog_kb(spelling)).
:- use_module(facetlog_kb(white_list)).
:- use_module(facetlog_kb(words)).
:- use_module(facetlog_kb(check)).
:- use_module(facetlog_kb(check_protocol)).
:- use_module(facetlog_kb(rule_module)).

:- meta_predicate general_terms(?, 0, -).

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

scope_of(Clauses, scope(rules, Own, Words, Tolerances, Measures)) :-
    findall(Name/Arity, ( head_among(Clauses, Head, _), functor(Head, Name, Arity) ), Own0),
    sort(Own0, Own1),
    findall(Indicator-own, member(Indicator, Own1), Pairs),
    ord_list_to_assoc(Pairs, Own),
    general_terms(Word, head_among(Clauses, means(Word, _), _), Words),
    general_terms(Measure, head_among(Clauses, measured(Measure, _, _, _), _), Measures),
    findall(Name, ( head_among(Clauses, tolerance(Name, _), _), atom(Name) ), Tolerances).

%   What Goal says of Term, each with fresh arguments, once.
general_terms(Term, Goal, Terms) :-
    findall(Name/Arity, ( call(Goal), callable(Term), functor(Term, Name, Arity) ), Indicators0),
    sort(Indicators0, Indicators),
    findall(General, ( member(Name/Arity, Indicators), functor(General, Name, Arity) ), Terms).

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
    Arity =\= Right,
    !,
    name_position(Position, At),
    fault_at(At, "~w has ~d arguments, not ~d; see docs/model-reference.md", [Name, Right, Arity], Fault).
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

%   Every model says what it looks for, among what, and by which conditions.
file_fault(_, [], fault(0, 0, "a model needs ~w; see docs/model-reference.md", [model/3])).
file_fault(Clauses, Models, fault(Start, End, "the model ~w needs ~w; see docs/model-reference.md",
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
