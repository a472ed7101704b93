:- module(facetlog_bridge, [ request/4         % +Number, +Operation, +Text, -Reply
                           ]).

/** <module> The one door between Python and Prolog

Python hands over an operation and a text, a Prolog term; each solution is a reply, a list of
strings. The first string is JSON: ["ok", ...] with the result, or ["error", Kind, Message, Place].
A question replies with as many chunks as it has (answers.pl), everything else once. A request never
raises but for an interrupt that arrives on its very threshold.
*/

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
:- use_module(facetlog_kb(pairs)).
:- use_module(facetlog_kb(batch)).
:- use_module(facetlog_kb(near_miss)).
:- use_module(facetlog_kb(origin)).
:- use_module(facetlog_kb(sight)).
:- use_module(facetlog_kb(ask)).
:- use_module(facetlog_kb(loader)).
:- use_module(facetlog_kb(reading)).
:- use_module(facetlog_kb(question)).
:- use_module(facetlog_kb(array_plan)).
:- use_module(facetlog_kb(words)).
:- use_module(facetlog_kb(bounded_text)).
:- use_module(facetlog_kb(small_terms)).
:- use_module(facetlog_kb(plain_errors)).
:- use_module(facetlog_kb(answers)).
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
    (   nb_getval(facetlog_request, Number)
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
operation("add_facts", Text, [Reply]) :-
    !,
    % The first term of the text names the scene.
    setup_call_cleanup(
        open_string(Text, Stream),
        ( read_term(Stream, Scene, []),
          add_facts(Scene, Stream) ),
        close(Stream)),
    ok(true, Reply).
operation("query", Text, [Head|Chunk]) :-
    term_string(query(Base, Scenes, Most, Fewest, Bounds, Bindings, Question), Text),
    bounded(Bounds, answers(Fewest, Base, Scenes, Most, Bindings, Question, Head0, Chunk)),
    ok(Head0, Head).

%   Head are the names of the columns of each Chunk. Where arrays can find the answers, and there are
%   at least Fewest facts to look at, there is first plan(Names, Scenes, Plan) (array_plan.pl). The
%   chunks come after it, for whoever cannot follow it. Of its scenes it has
%   scene(Name, Scene, Generations), which tell when each fact of the plan was last changed.
answers(Fewest, Base, Scenes, Most, Bindings, Text, Head, Chunk) :-
    ask_base(Base, Scenes),
    question(Text, Bindings, question(Goal, Names0, Vars, PerScene, Checked)),
    (   PerScene == true
    ->  findall(Asked, asked_scene(Base, Scenes, Asked), All),
        scene_column(All, Names0, Names),
        (   planned(Fewest, All, Checked, Vars, Dated, Plan),
            Head = plan(Names, Dated, Plan),
            Chunk = []
        ;   Head = Names,
            per_scene(All, Goal, Vars, Row, Run),
            chunk(Row, Run, Most, Chunk)
        )
    ;   nb_setval(facetlog_scene, none),
        Head = Names0,
        chunk(Vars, facetlog_query:Goal, Most, Chunk)
    ).

scene_column([_], Names, Names) :- !.
scene_column(_, Names, _) :-
    memberchk('Scene', Names),
    !,
    throw(question_error(0, 0, "Scene is the name of the first column when several scenes are asked: call this variable something else", [])).
scene_column(_, Names, ['Scene'|Names]).

planned(Fewest, All, checked(Goal, Scope), Vars, Dated, Plan) :-
    integer(Fewest),
    findall(Indicator, fact_schema(Indicator, _), Every),
    mostly_large(All, Every, Fewest),   % sooner seen than a plan is made
    array_plan(Goal, Vars, Scope, Plan),
    !,
    Plan = plan(_, _, Facts),
    mostly_large(All, Facts, Fewest),
    maplist(dated(Facts), All, Dated).

dated(Facts, Name-Scene, scene(Name, Scene, Generations)) :-
    maplist(last_changed(Scene), Facts, Generations).

%   Most scenes have a fact that is there so often. Of few facts Prolog is as fast.
mostly_large(All, Facts, Fewest) :-
    partition(large(Facts, Fewest), All, Large, Small),
    length(Large, Count),
    length(Small, Rest),
    Count > Rest.

large(_, 0, _) :- !.
large(Facts, Fewest, _-Scene) :-
    member(Name/Arity, Facts),
    functor(Head, Name, Arity),
    nth_clause(Scene:Head, Fewest, _),
    !.

%   To count the clauses would take as long as to visit them.
last_changed(Scene, Name/Arity, Generation) :-
    functor(Head, Name, Arity),
    (   predicate_property(Scene:Head, last_modified_generation(Generation0))
    ->  Generation = Generation0
    ;   Generation = 0
    ).

per_scene([_-Scene], Goal, Vars, Vars, in_scene(Scene, facetlog_query:Direct)) :-
    !,
    direct(Goal, Scene, Direct).
per_scene(All, Goal, Vars, [Name|Vars],
          ( member(Name-Scene, All), in_scene(Scene, facetlog_query:Direct) )) :-
    direct(Goal, Scene, Direct).

%   Facts that are asked outright are asked of the scene itself: that is twice as fast as to look for
%   the current one.
direct(Goal, _, Goal) :-
    var(Goal),
    !.
direct(fact(Fact), Scene, Scene:Fact) :- !.
direct((A , B), Scene, (C , D)) :- !, direct(A, Scene, C), direct(B, Scene, D).
direct((A ; B), Scene, (C ; D)) :- !, direct(A, Scene, C), direct(B, Scene, D).
direct((A -> B), Scene, (C -> D)) :- !, direct(A, Scene, C), direct(B, Scene, D).
direct((A *-> B), Scene, (C *-> D)) :- !, direct(A, Scene, C), direct(B, Scene, D).
direct(\+ A, Scene, \+ B) :- !, direct(A, Scene, B).
direct(Goal, _, Goal).

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
result("load_rules", Text, Loaded) :-
    term_string(rules(Module, File, Rules), Text),
    load_rules(Module, File, Rules, Loaded).
result("load_trusted_rules", Text, Loaded) :-
    term_string(rules(Module, File, Rules), Text),
    load_trusted_rules(Module, File, Rules, Loaded).
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
result("why", Text, Verdict) :-
    explained(Text, why(Module, Model, Things, Given),
              why(Module, Model, Things, Given, Verdict)).
result("why_not", Text, Verdicts) :-
    explained(Text, why_not(Module, Model, Things, Given, Count),
              why_not(Module, Model, Things, Given, Count, Verdicts)).
result("open_batch", Text, Asked) :-
    term_string(batch(Base, Batch, Scene, Models), Text),
    ask_base(Base, all),
    open_batch(Batch, Scene, Models, Asked).
result("judge_batch", Text, Verdicts) :-
    once(sub_string(Text, End, 1, _, "\n")),
    sub_string(Text, 0, End, _, Line),
    term_string(batch(Base, Batch, Bounds), Line),
    Start is End + 1,
    sub_string(Text, Start, _, 0, Columns),
    ask_base(Base, all),
    setup_call_cleanup(
        true,
        bounded(Bounds, told_verdicts(Batch, Columns, Verdicts)),
        empty_batch(Batch)).
result("batch_conditions", Text, Models) :-
    term_string(batch(_, Batch), Text),
    batch_conditions(Batch, Models).
result("close_batch", Text, true) :-
    term_string(Batch, Text),
    close_batch(Batch).
result("pair_graph", Text, graph(Names, Later)) :-
    explained(Text, pair_graph(Test), pair_graph(Test, Names, Later)).
result("passing_values", Text, Numbers) :-
    explained(Text, passing_values(Test, Values), passing_values(Test, Values, Numbers)).
result("origin", Text, Origin) :-
    explained(Text, origin(Name), ( about(Name, About), origin(About, Origin) )).
result("sight", Text, Sight) :-
    explained(Text, sight(Thing), sight(Thing, Sight)).
result("version", _, Version) :-
    current_prolog_flag(version, Version).
result("statistics", _, [Modules, Clauses]) :-
    aggregate_all(count, current_module(_), Modules),
    statistics(clauses, Clauses).
result("interrupt", Text, true) :-
    term_string(interrupt(Thread, Number, Why), Text),
    catch(thread_signal(Thread, facetlog_bridge:interrupt(Number, Why)), _, true).

%!  known_of_scene(?What, +Scene) is nondet.
%
%   What the caller keeps of a scene: its lengths are metric; a thing is known from its surface, as those
%   of meshes and clouds are, and not from pictures.

known_of_scene(metric, Scene) :- catch(Scene:scale(metric), _, fail).
known_of_scene(whole(Thing), Scene) :- catch(Scene:whole(Thing), _, fail).
known_of_scene(scanned(Thing), Scene) :- catch(Scene:scanned(Thing), _, fail).

%   Bases that take all values as exact (quantities.pl).
:- dynamic crisp_base/1.

%   What is asked from here on is asked of Base.
ask_base(Base, Scenes) :-
    b_setval(facetlog_asked, Base-Scenes),
    ( crisp_base(Base) -> Crisp = true ; Crisp = false ),
    b_setval(facetlog_crisp, Crisp).

explained(Text, Request, Goal) :-
    term_string(asked(Base, Scene, Bounds, Request), Text),
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
    told_shortly(Error0, Error),
    catch(( fault(Error, Kind0, Message0, Place0),
            placed(Kind0, Message0, Place0, Error, Operation, Text, Kind, Message, Place) ), _,
          ( Kind = "prolog", Message = "an error that cannot be shown", Place = [] )),
    json_reply([text("error"), text(Kind), text(Message), term(Place)], Reply).

%   Faults are our own texts; whatever else may hold a term of any size.
told_shortly(Error, Error) :-
    ( Error = rule_faults(_) ; Error = question_error(_, _, _, _) ),
    !.
told_shortly(Error, Short) :-
    shortened(Error, Short).

fault(facetlog_interrupt(Why), "limit", Message, []) :-
    !,
    interrupt_message(Why, Message).
fault(question_error(Start, End, Format, Args), "question", Message, [Start, End]) :-
    !,
    format(string(Message), Format, Args).
fault(rule_faults(Messages), "rules", Message, []) :-
    !,
    atomic_list_concat(Messages, '\n', Message).
fault(error(type_error(comparable, Test), _), "rules", Message, []) :-
    !,
    format(string(Message),
           "~p compares a length with a bare number: write metres(...) or a share of another length",
           [Test]).
fault(error(existence_error(Kind, What), _), "rules", Message, []) :-
    memberchk(Kind, [word, tolerance]),
    !,
    format(string(Message), "~p is no ~w of the model or the vocabulary", [What, Kind]).
fault(error(existence_error(model, Model), _), "rules", Message, []) :-
    !,
    format(string(Message), "a rule asks for the model ~w, which is not loaded", [Model]).
fault(error(existence_error(Kind, Name), _), "question", Message, [0, 0]) :-
    nothing_of(Kind, Format),
    !,
    format(string(Message), Format, [Name]).
fault(error(python_error(Key, Message), _), "python", Message, [Key]) :- !.
fault(inference_limit_exceeded, "limit", "the limit of inferences was reached", []) :- !.
fault(error(resource_error(What), _), "limit", Message, []) :-
    !,
    resource(What, Name),
    format(string(Message), "the limit of ~w was reached", [Name]).
fault(models_not_ready(Models, Error), Kind, Message, Place) :-
    !,
    fault(Error, Kind, Why, Place),
    atomic_list_concat(Models, ', ', Names),
    format(string(Message), "the model ~w cannot be prepared: ~w", [Names, Why]).
fault(Error, "prolog", Message, []) :-
    plain_error(Error, Message),
    !.
fault(Error, "prolog", Message, []) :-
    '$messages':translate_message(Error, Lines, [nl]),
    with_output_to(string(Message0), print_message_lines(current_output, '', Lines)),
    normalize_space(string(Message), Message0).

nothing_of(thing, "the scene has no thing ~w").
nothing_of(part, "the scene has no face or edge ~w").
nothing_of(role, "the model has no part ~w").
nothing_of(name, "the scene has neither a name nor a fact ~w").

interrupt_message(time_limit, "the time limit was reached").
interrupt_message(stopped, "the question was stopped").

resource(inferences, "inferences") :- !.
resource(What, "memory (Prolog's stacks)") :- memberchk(What, [stack, private_table_space]), !.
resource(text, "text (characters of names that are made)") :- !.
resource(term_size, "the size of a term") :- !.
resource(number_length, "the length of a number") :- !.
resource(What, What).
