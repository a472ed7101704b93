:- module(facetlog_batch, [ open_batch/4,         % +Batch, +Scene, +Models, -Kinds
                            save_batch/3,         % +Batch, +File, -Count
                            load_batch/4,         % +Batch, +Scene, +File, +Count
                            encoded_verdicts/4,   % +Batch, +Facts, +Inferences, -Encoded
                            brief_verdicts/3,     % +Batch, +Inferences, -Verdicts
                            batch_conditions/2,   % +Batch, -Models
                            empty_batch/1,        % +Batch
                            close_batch/1         % +Batch
                          ]).

/** <module> Brief verdicts on one scene after the other

A batch has one module for the facts of the scene at hand, filled and emptied, and its models written
anew for it (specialise.pl). A brief verdict is

    brief(Model, Thing, State, Low, High, Parts, Sizes, Cost)

with the same values as in the verdict of judge.pl, whose other arguments it lacks. Cost is
cost(Candidates, Inferences, Seconds): how many assignments were proposed, or which limit was reached,
`stacks` or `inferences`, and what the verdict took, in seconds of processor time.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(facetlog_kb(schema)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog_kb(judge)).
:- use_module(facetlog_kb(target)).
:- use_module(facetlog_kb(specialise)).
:- use_module(facetlog_kb(model_descriptions)).
:- use_module(facetlog_kb(facts_on_demand)).
:- use_module(library(aggregate)).
:- use_module(facetlog_kb(scene_cache)).

:- dynamic batch_scene/2,               % Batch, Scene
           batch_model/4,               % Batch, Model, Module, Target or none
           batch_fact/2.                % Batch, Head

%!  open_batch(+Batch, +Scene, +Models, -Kinds) is det.
%
%   Models are Module-[Model, ...] in the order of the verdicts. Kinds lists the functors Name-Arity
%   that a scene needs facts of; it may have others. What load_batch/4 has loaded is not written again.
%
%   @throws models_not_ready(Models, Error) if Error stops the writing of Models.

open_batch(Batch, Scene, Models, Kinds) :-
    (   batch_scene(Batch, Scene)
    ->  true
    ;   begin_batch(Batch, Scene),
        ( nb_current(facetlog_crisp, Crisp) -> true ; Crisp = false ),
        forall(member(Module-Names, Models), open_models(Batch, Scene, Crisp, Module, Names))
    ),
    findall(Name-Arity, needed(Batch, Scene, Name/Arity), Kinds0),
    sort(Kinds0, Kinds),
    forall(member(Name-Arity, Kinds),
           ( functor(Head, Name, Arity), assertz(batch_fact(Batch, Head)) )).

begin_batch(Batch, Scene) :-
    new_scene(Scene),
    prepare_facts(Scene),
    assertz(batch_scene(Batch, Scene)).

%   The module of the facts is that of the new clauses, too: they call no other temporary one.
open_models(Batch, Scene, Crisp, Module, Names) :-
    forall(member(Name, Names), open_model(Batch, context(Module, Scene, Crisp), Name)).

open_model(Batch, Context, Name) :-
    Context = context(Module, Scene, _),
    (   catch(attempt(Context, facetlog_general(_), specialised(Name, Context)),
              Error, throw(models_not_ready([Name], Error)))
    ->  Target = Scene
    ;   Target = none
    ),
    assertz(batch_model(Batch, Name, Module, Target)).

needed(_, _, thing/1).
needed(_, Scene, Indicator) :-
    asked_of_scene(Scene, Indicator).
needed(Batch, _, Indicator) :-
    batch_model(Batch, _, _, none),
    fact_schema(Indicator, _).

%!  save_batch(+Batch, +File, -Count) is det.
%
%   Writes the Count clauses of an open batch, which holds no scene yet, to File. They name its module.
%
%   @error io_error or permission_error if File cannot be written.

save_batch(Batch, File, Count) :-
    batch_scene(Batch, Scene),
    findall(models(Model, Module, Target), batch_model(Batch, Model, Module, Target), Models),
    save_code(Scene, Models, File, Count).

%!  load_batch(+Batch, +Scene, +File, +Count) is semidet.
%
%   Opens the Batch of the models of File, which names Scene. Fails, and nothing is open, if it has not
%   Count clauses.

load_batch(Batch, Scene, File, Count) :-
    begin_batch(Batch, Scene),
    (   catch(load_code(Scene, File, Count, Models), _, fail)
    ->  forall(member(models(Model, Module, Target), Models),
               assertz(batch_model(Batch, Model, Module, Target)))
    ;   close_batch(Batch),
        fail
    ).

%!  close_batch(+Batch) is det.

close_batch(Batch) :-
    retractall(batch_model(Batch, _, _, _)),
    retractall(batch_fact(Batch, _)),
    forall(retract(batch_scene(Batch, Scene)), ( forget_code(Scene), destroy_scene(Scene) )).

%!  empty_batch(+Batch) is det.
%
%   Forgets the facts of the scene at hand, and all that was found out about it.

empty_batch(Batch) :-
    batch_scene(Batch, Scene),
    forall(batch_fact(Batch, Head), retractall(Scene:Head)),
    drop_facts(Scene),
    retractall(Scene:'facetlog recall'(_, _, _, _, _, _)),
    forget_remembered(Scene).

%!  encoded_verdicts(+Batch, +Facts, +Inferences, -Encoded) is det.
%
%   Encoded is brief_verdicts/3 on the facts of the text Facts (facts_on_demand.pl): one string, which
%   is written and read faster than terms. It has the atoms and numbers of all verdicts in order, each
%   list after its length and each part after `part` or `group`, with a separator between them; or, if a
%   name has the separator in it, Encoded is the list of them.

encoded_verdicts(Batch, Facts, Inferences, Encoded) :-
    batch_scene(Batch, Scene),
    await_facts(Scene, Facts),
    brief_verdicts(Batch, Inferences, Verdicts),
    foldl(fields, Verdicts, Fields, []),
    separator(Separator),
    atomic_list_concat(Fields, Separator, Text),
    (   atomic_list_concat(Split, Separator, Text),
        same_length(Split, Fields)
    ->  atom_string(Text, Encoded)
    ;   Encoded = Fields
    ).

separator('\x7f\').     % as in batch_judge.py; no JSON escapes it

fields(brief(Model, Thing, State, Low, High, Parts, Sizes, cost(Candidates, Inferences, Seconds)),
       [Model, Thing, State, Low, High, Candidates, Inferences, Seconds, PartCount|Fields], Rest) :-
    length(Parts, PartCount),
    foldl(part_fields, Parts, Fields, [SizeCount|SizeFields]),
    length(Sizes, SizeCount),
    foldl(size_fields, Sizes, SizeFields, Rest).

part_fields(group(Role, Names), [group, Role, Count|Fields], Rest) :-
    length(Names, Count),
    append(Names, Rest, Fields).
part_fields(Role-Part, Fields, Rest) :-
    (   is_list(Part)
    ->  part_fields(group(Role, Part), Fields, Rest)
    ;   Fields = [part, Role, Part|Rest]
    ).

size_fields(size(Name, V, Sd), [Name, V, Sd|Rest], Rest).

%!  brief_verdicts(+Batch, +Inferences, -Verdicts) is det.
%
%   On each thing of the scene at hand each model's, in their orders. All together take no more than
%   most of the Inferences, and one of them no more than a share: who needs more is unknown, and those
%   after it are judged.

most_of(0.9).           % the rest is for all that is no judging
share_of_one(0.1).

brief_verdicts(Batch, Inferences, Verdicts) :-
    batch_scene(Batch, Scene),
    statistics(inferences, Begun),
    most_of(Most),
    share_of_one(Share),
    End is Begun + integer(Most*Inferences),
    One is integer(Share*Inferences),
    b_setval(facetlog_scene, Scene),
    findall(Thing, Scene:thing(Thing), Things),
    findall(Verdict,
            ( member(Thing, Things),
              batch_model(Batch, Model, Module, Target),
              brief(Target, Module, Model, Thing, One, End, Verdict) ),
            Verdicts).

brief(Target, Module, Model, Thing, One, End, Verdict) :-
    Verdict = brief(Model, _, _, _, _, _, _, cost(_, Inferences, Seconds)),
    statistics(inferences, Inferences0),
    statistics(cputime, Seconds0),
    Limit is min(One, End - Inferences0),
    (   Limit > 0
    ->  catch(call_with_inference_limit(judged(Target, Module, Model, Thing, Verdict), Limit, Result),
              error(resource_error(stack), _),
              beyond_limit(stacks, Model, Thing, Verdict))
    ;   Result = inference_limit_exceeded
    ),
    (   Result == inference_limit_exceeded
    ->  beyond_limit(inferences, Model, Thing, Verdict)
    ;   true
    ),
    statistics(cputime, Seconds1),
    statistics(inferences, Inferences1),
    Inferences is Inferences1 - Inferences0,
    Seconds is Seconds1 - Seconds0.

%   A thing with hundreds of faces in one place may fill the stacks with one model's assignments, or take
%   longer than anybody waits: only that is unknown then.
beyond_limit(Limit, Model, Thing, brief(Model, Thing, unknown, 0, 1, [], [], cost(Limit, _, _))).

judged(none, Module, Model, Thing,
       brief(Model, Of, State, Low, High, Parts, Sizes, cost(0, _, _))) :-
    !,                                  % how many were proposed only search.pl knows
    judge(Module, Model, Thing, verdict(_, Of, State, Low, High, Parts, Measured, _, _, _)),
    findall(size(Name, V, Sd), member(size(Name, V, Sd, _), Measured), Sizes).
judged(Target, Module, Model, Thing, Verdict) :-
    findall(Thing-Parts, Target:candidate(Model, Thing, Parts), Bag),
    sort(Bag, Candidates),
    length(Candidates, Count),
    (   Candidates == []
    ->  Verdict = brief(Model, Thing, unknown, 0, 1, [], [], _)
    ;   Target:cheapest(Model, Names),
        all_hopeless(Names, Target, Candidates)
    ->  Verdict = brief(Model, Thing, fails, 0, 0, [], [], _)
    ;   Target:plan(Model, Plan),
        best_by(Plan, Module, Model, Candidates, found(Of, Parts, _), _),
        brief_on(Target, Module, Model, Of, Parts, Verdict)
    ),
    Verdict = brief(_, _, _, _, _, _, _, cost(Count, _, _)),
    !.

%   The conditions in the order of the file, in which a proof has them: not a digit differs.
brief_on(Target, Module, Model, Thing, Parts,
         brief(Model, Thing, State, Low, High, Roled, Sizes, _)) :-
    Target:lines(Model, Names),
    all_outlined(Names, Target, Thing, Parts, outline(State, Low, High)),
    roled_in(Module, Model, Target, Thing, Parts, Roled),
    findall(size(Name, V, Sd),
            ( Target:size(Model, Thing, Parts, Name, V, Var), Sd is sqrt(Var) ),
            Sizes).

                 /*******************************
                 *       WHAT RUNS HOW          *
                 *******************************/

%!  batch_conditions(+Batch, -Models) is det.
%
%   Models has conditions(Model, Count, Interpreted) for each model, in their order: Interpreted are the
%   labels of those of its Count conditions of which some or all is left to the interpreter.

batch_conditions(Batch, Models) :-
    findall(conditions(Model, Count, Interpreted),
            ( batch_model(Batch, Model, Module, Target),
              findall(Label, clause(Module:condition(Model, Label, _, _, _, _), _), Labels),
              length(Labels, Count),
              interpreted(Target, Model, Labels, Interpreted) ),
            Models).

interpreted(none, _, Labels, Labels) :- !.
interpreted(Target, Model, Labels, Interpreted) :-
    Target:lines(Model, Names),
    findall(Label,
            ( nth1(Number, Names, Name),
              calls_interpreter(Target, Name/3),
              nth1(Number, Labels, Label) ),
            Interpreted).

                 /*******************************
                 *       COMPILED FILES        *
                 *******************************/

%   To write models anew for a batch takes longer than all else at its start, and what is written depends
%   on the models and the program alone: it is kept as scenes are (scene_cache.pl). A file has the clauses
%   of one target, and one of its own with all that must be known of these: which predicates have none yet,
%   and what target.pl has noted. It is loaded into a target of the same name, for clauses name it.

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
