:- module(facetlog_saved_code, [ save_code/4,         % +Target, +About, +File, -Count
                                 load_code/4          % +Target, +File, +Count, -About
                               ]).

/** <module> Specialised models as compiled files

To write models anew for a batch takes longer than all else at its start, and what is written depends
on the models and the program alone: it is kept as scenes are (scene_cache.pl). A file has the clauses
of one target, and one of its own with all that must be known of these: which predicates have none yet,
and what target.pl has noted. It is loaded into a target of the same name, for clauses name it.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(library(aggregate)).
:- use_module(facetlog_kb(schema)).
:- use_module(facetlog_kb(target)).
:- use_module(facetlog_kb(scene_cache)).

%!  save_code(+Target, +About, +File, -Count) is det.
%
%   Writes the Count clauses of Target to File, which holds no facts yet, and the term About with them.
%
%   @error io_error or permission_error if File cannot be written.

save_code(Target, About, File, Count) :-
    findall(Name/Arity, own(Target, Name/Arity), Own),
    partition(has_clauses(Target), Own, Written, Empty),
    code_notes(Target, Notes),
    maplist(head, Written, Heads),
    setup_call_cleanup(
        assertz(Target:'saved code'(Empty, Notes, About)),
        save_module(Target, ['saved code'(_, _, _)|Heads], File),
        retractall(Target:'saved code'(_, _, _))),
    clause_count(Target, Count).

%   What is no fact of the schema.
own(Target, Name/Arity) :-
    current_predicate(Target:Name/Arity),
    functor(Head, Name, Arity),
    \+ predicate_property(Target:Head, imported_from(_)),
    \+ fact_schema(Name/Arity, _).

has_clauses(Target, Indicator) :-
    head(Indicator, Head),
    predicate_property(Target:Head, number_of_clauses(Number)),
    Number > 0.

head(Name/Arity, Head) :-
    functor(Head, Name, Arity).

clause_count(Target, Count) :-
    aggregate_all(sum(Number),
                  ( own(Target, Indicator),
                    head(Indicator, Head),
                    predicate_property(Target:Head, number_of_clauses(Number)) ),
                  Count).

%!  load_code(+Target, +File, +Count, -About) is semidet.
%
%   Adds the clauses of File to Target, a scene without facts. Fails if they are not Count.

load_code(Target, File, Count, About) :-
    load_saved_module(Target, File),
    Target:'saved code'(Empty, Notes, About),
    abolish(Target:'saved code'/3),
    maplist(begun(Target), Empty),
    note_again(Target, Notes),
    clause_count(Target, Count).

begun(Target, Indicator) :-
    head(Indicator, Head),
    declared(Target, Head).
