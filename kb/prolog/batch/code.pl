:- module(facetlog_code, [ open_code/3,         % +Target, +Models, -Kinds
                           save_code/3,         % +Target, +File, -Count
                           load_code/3,         % +Target, +File, +Count
                           code_model/3,        % ?Target, ?Model, ?Module
                           empty_code/1,        % +Target
                           close_code/1,        % +Target
                           with_code/4,         % +Module, +Model, -Target, :Goal
                           prepare_code/3,      % +Module, +Models, -Kinds
                           use_code/1,          % +Target
                           drop_code/1          % +Module
                         ]).

/** <module> The specialised rules of models, on any scene

The search of all verdicts runs on rules that were specialised (specialise.pl). Where scenes come one after the
other, their facts are put into the target itself (batch.pl). Everywhere else each fact of the target asks the
current scene, and what was found out of a scene is forgotten when the next one is asked.

Targets are shared by all threads: one searches at a time.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(library(aggregate)).
:- use_module(facetlog_kb(schema)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog_kb(scene_cache)).
:- use_module(facetlog_kb(target)).
:- use_module(facetlog_kb(specialise)).
:- use_module(facetlog_kb(facts_on_demand)).

:- meta_predicate with_code(+, +, -, 0), while_taken(+, +, 0).

:- dynamic code/4,                      % Module, Crisp, Model, Target
           open_now/1,                  % Target
           code_model/3,                % Target, Model, Module
           code_fact/2.                 % Target, Head

%!  open_code(+Target, +Models, -Kinds) is det.
%
%   Models are Module-[Model, ...] in the order of the verdicts. Kinds lists the functors Name-Arity
%   that a scene needs facts of; it may have others. What load_code/3 has loaded is not written again.
%
%   @throws models_not_ready(Models, Error) if Error stops the writing of Models.

open_code(Target, Models, Kinds) :-
    (   open_now(Target)
    ->  true
    ;   begin_code(Target),
        catch(open_models(Target, Models), Error, ( close_code(Target), throw(Error) )),
        note_facts(Target)
    ),
    findall(Name-Arity, ( code_fact(Target, Head), functor(Head, Name, Arity) ), Kinds0),
    sort(Kinds0, Kinds).

begin_code(Target) :-
    new_scene(Target),
    prepare_facts(Target),
    assertz(open_now(Target)).

%   The module of the facts is that of the new clauses, too: they call no other temporary one.
open_models(Target, Models) :-
    ( nb_current(facetlog_crisp, Crisp) -> true ; Crisp = false ),
    forall(( member(Module-Names, Models), member(Name, Names) ),
           open_model(Target, context(Module, Target, Crisp), Name)).

open_model(Target, Context, Name) :-
    Context = context(Module, _, _),
    catch(specialised(Name, Context), Error, throw(models_not_ready([Name], Error))),
    assertz(code_model(Target, Name, Module)).

note_facts(Target) :-
    findall(Head,
            ( ( Indicator = thing/1 ; asked_of_scene(Target, Indicator) ), head(Indicator, Head) ),
            Heads0),
    sort(Heads0, Heads),
    forall(member(Head, Heads), assertz(code_fact(Target, Head))).

%!  code_model(?Target, ?Model, ?Module) is nondet.
%
%   Target judges Model, whose rules are those of Module.

%!  save_code(+Target, +File, -Count) is det.
%
%   Writes the Count clauses of an open target, which holds no scene yet, to File. They name the module.
%
%   @error io_error or permission_error if File cannot be written.

save_code(Target, File, Count) :-
    findall(Model-Module, code_model(Target, Model, Module), Models),
    write_clauses_of(Target, Models, File, Count).

%!  load_code(+Target, +File, +Count) is semidet.
%
%   Opens Target with the models of File. Fails, and nothing is open, if it has not Count clauses.

load_code(Target, File, Count) :-
    begin_code(Target),
    (   catch(add_clauses_of(Target, File, Count, Models), _, fail)
    ->  forall(member(Model-Module, Models), assertz(code_model(Target, Model, Module))),
        note_facts(Target)
    ;   close_code(Target),
        fail
    ).

%!  close_code(+Target) is det.

close_code(Target) :-
    retractall(code_model(Target, _, _)),
    retractall(code_fact(Target, _)),
    (   retract(open_now(Target))
    ->  forget_code(Target),
        destroy_scene(Target)
    ;   true
    ).

%!  empty_code(+Target) is det.
%
%   Forgets the facts of the scene at hand, and all that was found out about it.

empty_code(Target) :-
    forall(code_fact(Target, Head), retractall(Target:Head)),
    drop_facts(Target),
    retractall(Target:'facetlog recall'(_, _, _, _, _, _)),
    forget_remembered(Target).

                 /*******************************
                 *           ANY SCENE          *
                 *******************************/

%!  with_code(+Module, +Model, -Target, :Goal) is semidet.
%
%   Goal, once, while the facts of Target, which judges Model, are those of the current scene.

with_code(Module, Model, Target, Goal) :-
    code_of(Module, Model, Target),
    b_getval(facetlog_scene, Scene),
    taken_now(Taken),
    (   Scene == Target                     % its facts are there (batch.pl)
    ->  once(Goal)
    ;   member(Target-Scene0, Taken)
    ->  (   Scene0 == Scene
        ->  once(Goal)
        ;   setup_call_cleanup(             % in the middle of another scene
                forget_remembered(Target),
                while_taken(Target-Scene, Taken, Goal),
                forget_remembered(Target))
        )
    ;   with_mutex(facetlog_code,
                   setup_call_cleanup(
                       true,
                       while_taken(Target-Scene, Taken, Goal),
                       forget_remembered(Target)))
    ).

taken_now(Taken) :-
    ( nb_current(facetlog_taken, Taken0) -> Taken = Taken0 ; Taken = [] ).

while_taken(One, Taken, Goal) :-
    b_setval(facetlog_taken, [One|Taken]),
    call(Goal),
    !,
    b_setval(facetlog_taken, Taken).

%   One writes the rules, the others wait for it.
code_of(Module, Model, Target) :-
    crisp_now(Crisp),
    (   code(Module, Crisp, Model, Target)
    ->  true
    ;   with_mutex(facetlog_code, write_code(Module, Crisp, Model)),
        once(code(Module, Crisp, Model, Target))
    ).

write_code(Module, Crisp, Model) :-
    (   code(Module, Crisp, Model, _)
    ->  true
    ;   gensym('facetlog_code:', Target),
        open_code(Target, [Module-[Model]], _),
        use_code(Target)
    ).

%!  prepare_code(+Module, +Models, -Kinds) is det.
%
%   Specialises those of Models that are not yet. Kinds are the functors of the facts that they ask for.

prepare_code(Module, Models, Kinds) :-
    findall(Kind,
            ( member(Model, Models),
              code_of(Module, Model, Target),
              code_fact(Target, Head),
              functor(Head, Kind, _) ),
            Kinds0),
    sort(Kinds0, Kinds).

%!  use_code(+Target) is det.
%
%   The models of the open Target are judged by its rules from now on, on any scene.

use_code(Target) :-
    crisp_now(Crisp),
    forall(( code_fact(Target, Head), \+ clause(Target:Head, _) ),
           assertz((Target:Head :- facetlog_scene:fact(Head)))),
    forall(( code_model(Target, Model, Module), \+ code(Module, Crisp, Model, _) ),
           assertz(code(Module, Crisp, Model, Target))).

crisp_now(Crisp) :-
    ( nb_current(facetlog_crisp, Crisp0) -> Crisp = Crisp0 ; Crisp = false ).

%!  drop_code(+Module) is det.
%
%   Forgets the specialised rules of a module that goes. Nobody may be asking them.

drop_code(Module) :-
    findall(Target, retract(code(Module, _, _, Target)), Targets0),
    sort(Targets0, Targets),
    forall(( member(Target, Targets), \+ code(_, _, _, Target) ), close_code(Target)).

                 /*******************************
                 *       COMPILED FILES        *
                 *******************************/

%   To write models anew for a target takes longer than all else at its start, and what is written depends
%   on the models and the program alone: it is kept as scenes are (scene_cache.pl). A file has the clauses
%   of one target, and one of its own with all that must be known of these: which predicates have none yet,
%   and what target.pl has noted. It is loaded into a target of the same name, for clauses name it.

%!  write_clauses_of(+Target, +About, +File, -Count) is det.
%
%   Writes the Count clauses of Target to File, which holds no facts yet, and the term About with them.
%
%   @error io_error or permission_error if File cannot be written.

write_clauses_of(Target, About, File, Count) :-
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

%!  add_clauses_of(+Target, +File, +Count, -About) is semidet.
%
%   Adds the clauses of File to Target, a scene without facts. Fails if they are not Count.

add_clauses_of(Target, File, Count, About) :-
    load_saved_module(Target, File),
    Target:'saved code'(Empty, Notes, About),
    abolish(Target:'saved code'/3),
    maplist(begun(Target), Empty),
    note_again(Target, Notes),
    clause_count(Target, Count).

begun(Target, Indicator) :-
    head(Indicator, Head),
    declared(Target, Head).
