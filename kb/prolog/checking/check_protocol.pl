:- module(facetlog_check_protocol, [ protocol/2,            % ?Name, ?Arity
                                     clause_of_model/5       % +Head, +Position, +Scope, +Models,
                                                             % -Fault
                                   ]).

/** <module> What is wrong with a clause that describes a model

The heads that docs/model-reference.md lists, each by its own rules. Models is a list of Name-Roles, Scope and
Fault are those of check.pl.
*/

:- use_module(library(lists)).
:- use_module(facetlog_kb(positions)).
:- use_module(facetlog_kb(spelling)).
:- use_module(facetlog_kb(words)).
:- use_module(facetlog_kb(check_tests)).
:- use_module(facetlog(vocabulary)).
:- use_module(facetlog(measures)).

%!  protocol(?Name, ?Arity) is nondet.
%
%   A predicate of this name has that many arguments. (Others that may be given are recognised by name and
%   number: files had helpers of such names before.)

protocol(model, 3).
protocol(candidate, 3).
protocol(condition, 6).
protocol(size, 5).
protocol(tolerance, 2).
protocol(means, 2).

%!  clause_of_model(+Head, +Position, +Scope, +Models, -Fault) is nondet.

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
clause_of_model(written(Name, Label, Place, Text), Position, _, Models, Fault) :-
    (   not_a_model(Name, Position, 1, Models, Fault)
    ;   nonvar(Label),
        \+ atom(Label),
        said_of(Position, 2, "a condition's label is a small word", Fault)
    ;   nonvar(Place),
        \+ is_text(Place),
        said_of(Position, 3, "a place is a text: 'slab.model:9'", Fault)
    ;   nonvar(Text),
        \+ is_text(Text),
        said_of(Position, 4, "what was written is a text", Fault)
    ).
clause_of_model(group(Name, _, Parts, Role, _), Position, _, Models, Fault) :-
    (   not_a_model(Name, Position, 1, Models, Fault)
    ;   parts_fault(Name, Parts, Position, 3, Models, Fault)
    ;   \+ atom(Role),
        said_of(Position, 4, "a group's role is a small word: legs", Fault)
    ;   member(Name-Roles, Models),
        is_list(Roles),
        memberchk(Role, Roles),
        said_of(Position, 4, "a part of the model has that role", Fault)
    ).
clause_of_model(specialises(Name, Other), Position, _, Models, Fault) :-
    (   not_a_model(Name, Position, 1, Models, Fault)
    ;   \+ atom(Other),
        said_of(Position, 2, "a model's name is a small word: box", Fault)
    ;   Name == Other,
        said_of(Position, 2, "every model is itself", Fault)
    ).
clause_of_model(rather_than(Name, Other), Position, Scope, Models, Fault) :-
    clause_of_model(specialises(Name, Other), Position, Scope, Models, Fault).
clause_of_model(measured(Measure, Value, Sd, Kind), Position, _, _, Fault) :-
    (   \+ callable(Measure),
        said_of(Position, 1, "measured/4 says how large something is: measured(lean(X), V, Sd, deg)",
                Fault)
    ;   callable(Measure),
        defined_measure(Measure, Format, Args),
        argument_position(Position, 1, At0),
        name_position(At0, At),
        fault_at(At, Format, Args, Fault)
    ;   member(Index-Number, [2-Value, 3-Sd]),
        nonvar(Number),
        \+ number(Number),
        said_of(Position, Index, "a measure has a number for its value and its deviation", Fault)
    ;   nonvar(Kind),
        \+ memberchk(Kind, [deg, ratio, count, length, area]),
        said_of(Position, 4, "a measure is of the kind deg, ratio, count, length or area", Fault)
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

is_text(Text) :-
    ( string(Text) ; atom(Text) ),
    !.

%   The vocabulary's measures and the operators come first.
defined_measure(Measure, "~q is a measure of the vocabulary and cannot be defined anew",
                [Name/Arity]) :-
    functor(Measure, Name, Arity),
    functor(General, Name, Arity),
    (   known_measure(General)
    ;   memberchk(Name/Arity, [tolerance/1, (+)/2, (-)/2, (*)/2, (/)/2, (-)/1])
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
