:- module(facetlog_bridge, [ request/4         % +Number, +Operation, +Text, -Reply
                           ]).

/** <module> The one door between Python and Prolog

Python hands over an operation and a text, a Prolog term; each solution is a reply, a list of
strings. The first string is JSON: ["ok", ...] with the result, or ["error", Kind, Message, Place].
A question replies with as many chunks as it has (answers.pl), everything else once. A request never
raises but for an interrupt that arrives on its very threshold.
*/

% All our files are UTF-8, whatever the locale.
:- set_prolog_flag(encoding, utf8).

% This file is kb/prolog/bridge.pl; rules/ stands beside kb/.
:- prolog_load_context(directory, Here),
   asserta(user:file_search_path(facetlog_kb, Here)),
   forall(member(Folder, [scenes, checking, meaning, searching, explaining, batch]),
          ( atomic_list_concat([Here, Folder], /, Path),
            assertz(user:file_search_path(facetlog_kb, Path)) )),
   absolute_file_name('../../rules', Rules, [relative_to(Here), file_type(directory)]),
   asserta(user:file_search_path(facetlog, Rules)).

:- use_module(library(aggregate)).
:- use_module(library(error)).
:- use_module(library(apply)).
:- use_module(library(lists)).
:- use_module(facetlog_kb(schema)).
:- use_module(facetlog_kb(json)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog_kb(fact_columns)).
:- use_module(facetlog_kb(scene_cache)).
:- use_module(facetlog_kb(judge)).
:- use_module(facetlog_kb(model_descriptions)).
:- use_module(facetlog_kb(code)).
:- use_module(facetlog_kb(batch)).
:- use_module(facetlog_kb(gallery)).
:- use_module(facetlog_kb(near_miss)).
:- use_module(facetlog_kb(members)).
:- use_module(facetlog_kb(origin)).
:- use_module(facetlog_kb(sight)).
:- use_module(facetlog_kb(ask)).
:- use_module(facetlog_kb(loader)).
:- use_module(facetlog_kb(named_models)).
:- use_module(facetlog_kb(reading)).
:- use_module(facetlog_kb(answers)).
:- use_module(facetlog_kb(words)).
:- use_module(facetlog_kb(bounded_text)).
:- use_module(facetlog_kb(small_terms)).
:- use_module(facetlog_kb(plain_errors)).
:- use_module(facetlog_kb(python)).
:- use_module(facetlog(vocabulary)).

%!  request(+Number, +Operation, +Text, -Reply) is nondet.

request(Number, Operation, Text, Reply) :-
    enter(Number),
    catch(call_cleanup(operation(Operation, Text, Reply0), Last = true), Error, true),
    (   nonvar(Error)
    ->  leave,
        problem(Error, Operation, Text, Reply)
    ;   Last == true
    ->  leave,
        Reply = Reply0
    ;   pause(Number),
        Reply = Reply0
    ).

%   An interrupt names the request that it is for: it may come late.
enter(Number) :-
    nb_setval(facetlog_request, Number),
    set_prolog_flag(encoding, utf8),    % of this thread; at first it is that of the locale
    own_stack_limit(Bytes),
    set_prolog_flag(stack_limit, Bytes).

%   What Prolog starts with: the limit of a question is its own, and the worker outlives it.
:- dynamic own_stack_limit/1.
:- current_prolog_flag(stack_limit, Bytes),
   asserta(own_stack_limit(Bytes)).

leave :-
    nb_setval(facetlog_request, none).

pause(_) :-
    leave.
pause(Number) :-
    nb_setval(facetlog_request, Number),
    fail.

%!  interrupt(+Number, +Why) is det.
%
%   Runs in the thread that serves the request Number, as a signal.

interrupt(Number, Why) :-
    (   nb_current(facetlog_request, Number)   % none in a thread that serves its first request
    ->  throw(facetlog_interrupt(Why))
    ;   true
    ).

                 /*******************************
                 *          OPERATIONS          *
                 *******************************/

operation(Operation, Text, [Reply]) :-
    deterministic(Operation),
    !,
    once(result(Operation, Text, Result)),
    ok(Result, Reply).
operation("query", Text, [Head|Chunk]) :-
    term_string(query(Base, Scenes, Most, Bounds, Bindings, Question), Text),
    bounded(Bounds, ( ask_base(Base, Scenes),
                      answers(Base, Scenes, Most, Bindings, Question, Head0, Chunk) )),
    ok(Head0, Head).

deterministic(Operation) :-
    clause(result(Operation, _, _), _),
    !.

result("declare_facts", Text, true) :-
    term_string(Declarations, Text),
    declare_facts(Declarations).
result("be_crisp", Text, true) :-
    term_string(Base, Text),
    assertz(crisp_base(Base)).
result("new_scene", Text, true) :-
    term_string(Scene, Text),
    new_scene(Scene).
result("add_columns", Text, true) :-
    add_columns(Text).
result("cache_identity", _, Identity) :-
    cache_identity(Identity).
result("save_scene", Text, Count) :-
    term_string(save(Scene, File), Text),
    save_scene(Scene, File, Count).
result("load_saved_scene", Text, Loaded) :-
    term_string(load(Scene, File, Count), Text),
    (   load_saved_scene(Scene, File, Count)
    ->  Loaded = true
    ;   Loaded = false
    ).
result("known_of_scene", Text, Known) :-
    term_string(Scene, Text),
    findall(What, known_of_scene(What, Scene), Known).
result("name_scene", Text, true) :-
    term_string(named(Base, Name, Scene), Text),
    name_scene(Base, Name, Scene).
result("unname_scene", Text, true) :-
    term_string(named(Base, Name), Text),
    unname_scene(Base, Name).
result("destroy_scene", Text, true) :-
    term_string(Scene, Text),
    destroy_scene(Scene).
result("load_builtin", Text, Loaded) :-
    term_string(Path, Text),
    load_builtin(Path, Loaded).
result("load_compiled", Text, Loaded) :-
    term_string(rules(Module, _, Rules), Text),
    load_compiled(Module, Rules, Loaded).
result("load_prolog", Text, Loaded) :-
    term_string(rules(Module, File, Rules), Text),
    load_prolog(Module, File, Rules, Loaded).
result("question_words", _, Words) :-
    question_words(Words).
result("name_models", Text, true) :-
    term_string(named(Base, Models, Module), Text),
    name_models(Base, Models, Module).
result("unname_models", Text, true) :-
    term_string(named(Base, Module), Text),
    unname_models(Base, Module).
result("drop_rules", Text, true) :-
    term_string(Module, Text),
    drop_rules(Module).
result("define_python", Text, true) :-
    term_string(define(Base, Indicator, Key), Text),
    define_python(Base, Indicator, Key).
result("forget_base", Text, true) :-
    term_string(Base, Text),
    undefine_python(Base),
    retractall(crisp_base(Base)),
    unname_scene(Base, _),
    unname_models(Base, _).
result("judge", Text, Verdict) :-
    explained(Text, judge(Module, Model, Thing), judge(Module, Model, Thing, Verdict)).
result("judge_near", Text, Verdict) :-
    explained(Text, judge_near(Module, Model, Thing),
              ( judge(Module, Model, Thing, Verdict0), add_near(Module, Verdict0, Verdict) )).
result("why", Text, Explained) :-
    explained(Text, why(Module, Model, Things, Given),
              why(Module, Model, Things, Given, Explained)).
result("why_not", Text, Verdicts) :-
    explained(Text, why_not(Module, Model, Things, Given, Count),
              why_not(Module, Model, Things, Given, Count, Verdicts)).
result("open_code", Text, opened(Kinds, General)) :-
    term_string(code(Base, Target, Models), Text),
    ask_base(Base, all),
    open_code(Target, Models, Kinds),
    findall(Model-Others,
            ( member(Module-Names, Models),
              member(Model, Names),
              general_models(Module, Model, Others),
              Others \== [] ),
            General).
result("save_code", Text, Count) :-
    term_string(save(Target, File), Text),
    save_code(Target, File, Count).
result("load_code", Text, Loaded) :-
    term_string(load(Target, File, Count), Text),
    (   load_code(Target, File, Count)
    ->  Loaded = true
    ;   Loaded = false
    ).
result("use_code", Text, true) :-
    term_string(code(Base, Target), Text),
    ask_base(Base, all),
    use_code(Target).
result("prepare_code", Text, Kinds) :-
    term_string(code(Base, Module, Models), Text),
    ask_base(Base, all),
    prepare_code(Module, Models, Kinds).
result("close_code", Text, true) :-
    term_string(Target, Text),
    close_code(Target).
result("judge_batch", Text, Verdicts) :-
    once(sub_string(Text, End, 1, _, "\n")),
    sub_string(Text, 0, End, _, Line),
    term_string(batch(Base, Target, Bounds), Line),
    Start is End + 1,
    sub_string(Text, Start, _, 0, Columns),
    ask_base(Base, all),
    Bounds = bounds(Inferences, _),
    setup_call_cleanup(
        true,
        bounded(Bounds, encoded_verdicts(Target, Columns, Inferences, Verdicts)),
        empty_code(Target)).
result("gallery_conditions", Text, Conditions) :-
    term_string(gallery(_, Module, Model), Text),
    gallery_conditions(Module, Model, Conditions).
result("judge_gallery", Text, Verdicts) :-
    term_string(gallery(Base, Module, Model, Inferences, Bounds, Scenes), Text),
    ask_base(Base, all),
    bounded(Bounds, gallery_verdicts(Module, Model, Scenes, Inferences, Verdicts)).
result("batch_conditions", Text, Models) :-
    term_string(code(_, Target), Text),
    batch_conditions(Target, Models).
result("origin", Text, Origin) :-
    explained(Text, origin(Name), ( about(Name, About), origin(About, Origin) )).
result("sight", Text, Sight) :-
    explained(Text, sight(Thing), sight(Thing, Sight)).
result("others_near", Text, Others) :-
    explained(Text, others_near(Thing), others_near(Thing, Others)).
result("statistics", _, [Modules, Clauses]) :-
    aggregate_all(count, current_module(_), Modules),
    statistics(clauses, Clauses).
result("interrupt", Text, true) :-
    term_string(interrupt(Thread, Number, Why), Text),
    catch(thread_signal(Thread, facetlog_bridge:interrupt(Number, Why)), _, true).

%!  known_of_scene(?What, +Scene) is nondet.
%
%   What the caller keeps of a scene: its lengths are metric; how many views it has; what share of a
%   thing's faces was seen; a thing is known from its surface, as those of meshes and clouds are, and not
%   from pictures.

known_of_scene(metric, Scene) :- catch(Scene:scale(metric), _, fail).
known_of_scene(views(Count), Scene) :- catch(aggregate_all(count, Scene:view(_, _), Count), _, fail).
known_of_scene(seen(Thing, Share), Scene) :- catch(seen_share(Scene, Thing, Share), _, fail).
known_of_scene(whole(Thing), Scene) :- catch(Scene:whole(Thing), _, fail).
known_of_scene(scanned(Thing), Scene) :- catch(Scene:scanned(Thing), _, fail).

seen_share(Scene, Thing, Share) :-
    aggregate(r(sum(Area), sum(Seen)),
              F^Sd^R^( Scene:part_of(F, Thing), Scene:area(F, Area, Sd), Scene:coverage(F, R),
                       Seen is Area * R ),
              r(All, Shown)),
    All > 0,
    Share is Shown / All.

%   Bases that take all values as exact (quantities.pl).
:- dynamic crisp_base/1.

%   Base is the current knowledge base from here on.
ask_base(Base, Scenes) :-
    b_setval(facetlog_base, Base-Scenes),
    ( crisp_base(Base) -> Crisp = true ; Crisp = false ),
    b_setval(facetlog_crisp, Crisp).

explained(Text, Request, Goal) :-
    term_string(request(Base, Scene, Bounds, Request), Text),
    ask_base(Base, all),
    bounded(Bounds, in_scene(Scene, Goal)).

%   What reads as a compound is a fact, anything else a name.
about(Text, Fact) :-
    catch(read_question(Text, Fact, _, _), question_error(_, _, _, _), fail),
    compound(Fact),
    !.
about(Text, Name) :-
    atom_string(Name, Text).

%   Inferences are counted anew for each solution, which is a chunk of answers: the caller, who
%   pulls the chunks, bounds the time of all of them.
bounded(bounds(Inferences, StackBytes), Goal) :-
    make_room,
    set_prolog_flag(stack_limit, StackBytes),
    renew_text_budget,
    call_with_inference_limit(Goal, Inferences, Result),
    renew_text_budget,                  % for the next chunk
    (   Result == inference_limit_exceeded
    ->  !,
        resource_error(inferences)
    ;   true
    ).

%   What nb_setarg/3 (in aggregate_all) keeps is kept with all that lies below it, from one request
%   to the next, and much that runs in C raises an error instead of collecting that garbage.
make_room :-
    statistics(globalused, Bytes),
    (   much_garbage(Much),
        Bytes > Much
    ->  garbage_collect,
        trim_stacks
    ;   true
    ).

%   A question that needs no more than this is not worth a collection, which takes some 0.1 ms.
much_garbage(1_000_000).

                 /*******************************
                 *            REPLIES           *
                 *******************************/

ok(Result, Reply) :-
    json_reply([text("ok"), term(Result)], Reply).

problem(Error0, Operation, Text, [Reply]) :-
    brief_error(Error0, Error),
    catch(( fault(Error, Kind0, Message0, Place0),
            placed(Kind0, Message0, Place0, Error, Operation, Text, Kind, Message, Place) ), _,
          ( Kind = "prolog", Message = "an error that cannot be shown", Place = [] )),
    json_reply([text("error"), text(Kind), text(Message), term(Place)], Reply).

%   Faults are our own texts; whatever else may hold a term of any size.
brief_error(Error, Error) :-
    ( Error = rule_faults(_) ; Error = question_error(_, _, _, _) ),
    !.
brief_error(Error, Short) :-
    shortened(Error, Short).
