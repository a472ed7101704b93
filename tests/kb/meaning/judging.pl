/*  What each way of judging says of the same cases (judging.py).

    Reads one case after the other from standard input,

        case(Facts, [Rules, Asking], Crisp, Tests, Pairs, Models).

    and writes for each a line with three lists:

      - for each test what the proof, the outline, the state, and the specialised goals in full and of
        the state alone say, as [State, Low, High, Miss] or [State], or the error that came instead;
        then the proof itself, for one test of four;
      - for each of Pairs, tests of X and Y, the pairs of faces that each_pair/4 finds;
      - for each model what its full and its brief verdict say.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(library(readutil)).
:- use_module(library(gensym)).
:- use_module(library(http/json)).

serve :-
    repeat,
    read_term(user_input, Term, []),
    (   Term == end_of_file
    ->  true
    ;   Term = case(Facts, Files, Crisp, Tests, Pairs, Models),
        (   answers(Facts, Files, Crisp, Tests, Pairs, Models, Answers0)
        ->  Answers = Answers0
        ;   Answers = []                % so that whoever waits for them sees it
        ),
        json_write_dict(user_output, Answers, [width(0)]),
        nl(user_output),
        flush_output(user_output),
        fail
    ).

answers(Facts, Files, Crisp, Tests, Pairs, Models, [TestRows, PairRows, Verdicts]) :-
    facetlog_bridge:ask_base(oracle_base, all),
    b_setval(facetlog_crisp, Crisp),
    maplist(loaded, [rules, asking], Files, Modules),
    Modules = [Rules, _],
    scene(Facts, Scene),
    b_setval(facetlog_scene, Scene),
    foldl(test_row(Rules, Scene, Crisp), Tests, TestRows, 0, _),
    maplist(pair_row(Rules), Pairs, PairRows),
    maplist(full_verdict, Models, Full),
    brief_verdicts(Modules, Facts, Models, Brief),
    maplist(two, Full, Brief, Verdicts),
    facetlog_target:forget_code(Scene),
    facetlog_scene:destroy_scene(Scene),
    maplist(dropped, Modules).

two(A, B, [A, B]).

scene(Facts, Scene) :-
    gensym(oracle, Scene),
    facetlog_scene:new_scene(Scene),
    facetlog_facts_on_demand:prepare_facts(Scene),
    forall(member(Fact, Facts), assertz(Scene:Fact)),
    forall(( schema:fact_schema(Name/Arity, _), functor(Head, Name, Arity) ),
           facetlog_target:declared(Scene, Head)).

                 /*******************************
                 *             RULES            *
                 *******************************/

loaded(Name, File, Module) :-
    gensym(Name, Module),
    load(File, Module, Models),
    facetlog_named_models:name_models(oracle_base, Models, Module).

load(Clauses, Module, Models) :-
    facetlog_loader:new_rule_module(Module),
    forall(member(Clause, Clauses), assertz(Module:Clause)),
    findall(Model, ( current_predicate(Module:model/3), Module:model(Model, _, _) ), Models).

dropped(Module) :-
    facetlog_named_models:unname_models(oracle_base, Module),
    '$destroy_module'(Module).

                 /*******************************
                 *             TESTS            *
                 *******************************/

test_row(Rules, Scene, Crisp, Test, [Proof, Outline, State, Full, Specialised, Steps], N, Next) :-
    Proved = proof(S1, L1, H1, _, _, _),
    answered(facetlog_prove:evaluate(Test, Rules, Proved), [S1, L1, H1], Proof),
    answered(facetlog_say:outline(Test, Rules, outline(S2, L2, H2, M2)), [S2, L2, H2, M2], Outline),
    answered(facetlog_say:state(Test, Rules, S3), [S3], State),
    Context = context(Rules, Scene, Crisp),
    specialised(Test, full, Context, said(S4, degree(L4, H4, M4)), [S4, L4, H4, M4], Full),
    specialised(Test, state, Context, said(S5, none), [S5], Specialised),
    (   N mod 4 =:= 0,
        nonvar(S1)
    ->  proof_row(Proved, Steps)
    ;   Steps = none
    ),
    Next is N + 1.

%   The faces of a test are known when it is asked, not when it is written.
specialised(Test0, Want, Context, Said, Answer, Row) :-
    Names = [f1, f2, f3, f4, t1],
    length(Variables, 5),
    pairs_keys_values(Pairs, Names, Variables),
    with_variables(Test0, Pairs, Test),
    Context = context(_, Scene, _),
    answered(( facetlog_partial:said_code(Test, Want, Context, Said, Code),
               flag(tests, Number, Number + 1),
               facetlog_target:helper(Context, test(Number), [Variables, Said], Head, _),
               assertz(Scene:(Head :- Code)),
               Variables = Names,
               call(Scene:Head) ), Answer, Row).

with_variables(Term, Pairs, Variable) :-
    atom(Term),
    memberchk(Term-Variable, Pairs),
    !.
with_variables(Term, Pairs, New) :-
    compound(Term),
    !,
    Term =.. [Name|Args0],
    maplist(with_variables_in(Pairs), Args0, Args),
    New =.. [Name|Args].
with_variables(Term, _, Term).

with_variables_in(Pairs, Term, New) :- with_variables(Term, Pairs, New).

%   The only answer: what leaves a choice says so.
answered(Goal, Answer, Row) :-
    catch(( call_cleanup(Goal, Only = true),
            ( Only == true -> Row = Answer ; Row = [choice|Answer] )
          ->  true
          ;   Row = [failed] ),
          Error, error_row(Error, Row)).

error_row(error(Formal, _), [error, Kind, Expected, Culprit]) :-
    Formal =.. [Kind, Expected0, Term],
    !,
    plain_text(Expected0, Expected),
    plain_text(Term, Culprit).
error_row(Error, [error, Text]) :- term_string(Error, Text).

%   Without operators and quotes.
plain_text(Term, Text) :-
    with_output_to(string(Text), write_term(Term, [ignore_ops(true)])).

                 /*******************************
                 *            PROOFS            *
                 *******************************/

proof_row(proof(State, Low, High, _, Detail, Children), [State, Low, High, Row, Rows]) :-
    detail_row(Detail, Row),
    maplist(proof_row, Children, Rows).

detail_row(missing(Measure, Cause), [missing, Text, Cause]) :-
    !,
    plain_text(Measure, Text).
detail_row(unseen(Free, Full, Detail), [unseen, Free, Full, Row]) :-
    !,
    detail_row(Detail, Row).
detail_row(Detail, Row) :-
    Detail =.. [Kind, Value, Sd, _, Within, margin(Side, Distance, MarginSd)],
    !,
    limits(Within, Limits),
    append([Kind, Value, Sd|Limits], [Side, Distance, MarginSd], Row).
detail_row(Detail, Row) :-
    Detail =.. Row.

limits(fading(Within, Width), Limits) :-
    !,
    limits(Within, Limits0),
    append(Limits0, [Width], Limits).
limits(soft(Within, Width), Limits) :-
    !,
    limits(fading(Within, Width), Limits).
limits(Within, Limits) :-
    Within =.. Limits.

                 /*******************************
                 *       PAIRS AND MODELS       *
                 *******************************/

pair_row(Rules, pair(X, Y, Test), Row) :-
    catch(findall([A, B], Rules:each_pair(X, Y, [A, B], Test), Row), Error, error_row(Error, Row)).

full_verdict(Model, Row) :-
    catch(( facetlog_named_models:model_module(Model, Module),
            facetlog_judge:judge(Module, Model, t1, Verdict),
            Verdict = verdict(_, _, State, Low, High, Parts, Sizes0, _, _, _),
            findall(size(Name, V, Sd), member(size(Name, V, Sd, _), Sizes0), Sizes),
            verdict_row(State, Low, High, Parts, Sizes, Row) ),
          Error, error_row(Error, Row)),
    !.

verdict_row(State, Low, High, Parts, Sizes, [State, Low, High, Roles, Rows]) :-
    findall([Role, Part], ( member(Of, Parts), role(Of, Role, Part) ), Roles),
    findall([Name, V, Sd], member(size(Name, V, Sd), Sizes), Rows).

role(group(Role, Members), Role, Members).
role(Role-Part, Role, Part).

%   Of a scene after another one, of which nothing may be remembered.
brief_verdicts(Modules, Facts, Models, Rows) :-
    findall(Module-Names,
            ( member(Module, Modules),
              findall(Model, ( member(Model, Models), facetlog_named_models:model_module(Model, Module) ),
                      Names),
              Names \== [] ),
            Asking),
    gensym(batch, Scene),
    catch(( facetlog_code:open_code(Scene, Asking, Asked),
            maplist(turned, Facts, Others),
            catch(brief_verdicts_on(Others, Scene, Asked, _), _, true),
            facetlog_code:empty_code(Scene),
            brief_verdicts_on(Facts, Scene, Asked, Verdicts),
            findall(Row,
                    ( member(Model, Models),
                      memberchk(brief(Model, _, State, Low, High, Parts, Sizes, _), Verdicts),
                      verdict_row(State, Low, High, Parts, Sizes, Row) ),
                    Rows) ),
          Error, ( error_row(Error, Row), findall(Row, member(_, Models), Rows) )),
    facetlog_code:empty_code(Scene),
    facetlog_code:close_code(Scene).

%   Only the facts that the batch asks for.
brief_verdicts_on(Facts, Scene, Asked, Verdicts) :-
    forall(( member(Fact, Facts), functor(Fact, Name, Arity), memberchk(Name-Arity, Asked) ),
           assertz(Scene:Fact)),
    facetlog_batch:brief_verdicts(Scene, 100_000_000, Verdicts).

%   What is so of one face is so of another.
turned(Fact0, Fact) :-
    Fact0 =.. [Name|Args0],
    maplist(turned_name, Args0, Args),
    Fact =.. [Name|Args].

turned_name(Name0, Name) :-
    ( nextto(Name0, Name1, [f1, f2, f3, f4, f1]) -> Name = Name1 ; Name = Name0 ).
