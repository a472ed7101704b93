:- module(facetlog_loader, [ load_builtin/2,         % +Path, -Loaded
                             load_rules/4,           % +Module, +File, +Text, -Loaded
                             load_trusted_rules/4,   % +Module, +File, +Text, -Loaded
                             drop_rules/1            % +Module
                           ]).

/** <module> Rule files into modules

A user's file is data until it is checked; then its clauses, prepared, go into a module of their
own. A file that the user trusts is ordinary Prolog. Loaded is loaded(Module, Models, Warnings);
a warning is a text that begins with File:Line:Column.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(library(error)).
:- use_module(facetlog_kb(reading)).
:- use_module(facetlog_kb(positions)).
:- use_module(facetlog_kb(check_rules)).
:- use_module(facetlog_kb(prepare)).
:- use_module(facetlog_kb(rule_module)).
:- use_module(facetlog_kb(trusted)).
:- use_module(facetlog_kb(recall)).

%   More faults of one file are not reported: whoever removes these sees the others.
most_faults(20).

%   Inferences for one file, some seconds: a long one of 25,000 clauses takes a tenth of them.
most_inferences(50_000_000).

%!  load_builtin(+Path, -Loaded) is det.
%
%   Loads a model that comes with the program.

load_builtin(Path, loaded(Module, Models, Names, [])) :-
    load_files(Path, [if(not_loaded), imports([]), silent(true)]),
    module_property(Module, file(Path)),
    models_in(Module, Models, Names).

%   Names has Model-Others of each model whose name stands before others.
models_in(Module, Models, Names) :-
    findall(Model, Module:model(Model, _, _), Models),
    (   current_predicate(Module:rather_than/2)
    ->  findall(Model-Other, Module:rather_than(Model, Other), Pairs0),
        keysort(Pairs0, Pairs),
        group_pairs_by_key(Pairs, Names)
    ;   Names = []
    ).

%!  load_rules(+Module, +File, +Text, -Loaded) is det.
%
%   The rules of Text go into the fresh module Module. Text is what stands in File, which is not
%   opened.
%
%   @throws rule_faults(Messages) with all faults of the text, each File:Line:Column: What.
%   @error resource_error(inferences) if that takes too long.

load_rules(Module, File, Text, Loaded) :-
    most_inferences(Most),
    call_with_inference_limit(load_checked(Module, File, Text, Loaded), Most, Result),
    (   Result == inference_limit_exceeded
    ->  ( current_module(Module) -> '$destroy_module'(Module) ; true ),
        resource_error(inferences)
    ;   true
    ).

load_checked(Module, File, Text, loaded(Module, Models, Names, Warnings)) :-
    read_rules(Text, Clauses, Unread),
    (   Unread == []
    ->  most_faults(Most),
        Sought is Most + 1,
        rules_faults(Clauses, Sought, Faults)
    ;   % What could not be read would be missed elsewhere.
        Faults = Unread
    ),
    (   Faults == []
    ->  true
    ;   fault_messages(File, Text, Faults, Messages),
        throw(rule_faults(Messages))
    ),
    rules_warnings(Clauses, Singles),
    fault_messages(File, Text, Singles, Warnings),
    new_rule_module(Module),
    catch(add_clauses(Clauses, Module), Error,
          ( '$destroy_module'(Module), not_added(Error, File, Text) )),
    models_in(Module, Models, Names).

add_clauses(Clauses, Module) :-
    scope_of(Clauses, Scope),
    forall(member(clause(Term, Position, _), Clauses),
           catch(add_clause(Term, Scope, Module), error(representation_error(What), _),
                 throw(not_added(Position, What)))).

not_added(not_added(Position, What), File, Text) :-
    !,
    span(Position, Start, End),
    fault_messages(File, Text, [fault(Start, End, "this is too large for Prolog: ~w", [What])], Messages),
    throw(rule_faults(Messages)).
not_added(Error, _, _) :-
    throw(Error).

add_clause((:- _), _, _) :- !.
add_clause((Head :- Body), Scope, Module) :-
    !,
    prepared(Body, Scope, Module, Goal),
    assertz(Module:(Head :- Goal)).
add_clause(Head, _, Module) :-
    assertz(Module:Head).

fault_messages(File, Text, Faults, Messages) :-
    most_faults(Most),
    sort(1, @=<, Faults, Sorted),
    length(Faults, Count),
    (   Count > Most
    ->  length(First, Most),
        append(First, _, Sorted),
        format(string(Rest), "~w: and more of the kind", [File]),
        Last = [Rest]
    ;   First = Sorted,
        Last = []
    ),
    maplist(message(File, Text), First, Messages0),
    append(Messages0, Last, Messages).

message(File, Text, fault(Start, _, Format, Args), Message) :-
    line_and_column(Text, Start, Line, Column),
    format(string(What), Format, Args),
    format(string(Message), "~w:~d:~d: ~w", [File, Line, Column, What]).

%!  load_trusted_rules(+Module, +File, +Text, -Loaded) is det.
%
%   Loads the Text of the file as ordinary Prolog, into the fresh module Module.
%
%   @throws rule_faults(Messages) if it does not load, or defines no whole model.

load_trusted_rules(Module, File, Text, loaded(Module, Models, Names, Warnings)) :-
    load_trusted(File, Text, Module, Warnings),
    models_in(Module, Models, Names).

%!  drop_rules(+Module) is det.
%
%   Forgets all that the file defined, in every module.

drop_rules(Module) :-
    (   unload_trusted(Module)
    ->  true
    ;   '$destroy_module'(Module)
    ).
