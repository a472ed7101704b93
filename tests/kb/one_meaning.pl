/*  What each way of judging says of the same tests (test_one_meaning.py).

    Reads one scene after the other from standard input,

        scene(Facts, Words, Crisp, Tests).

    and writes for each a line with a list of one row for each test, [Ways, ...]: what the proof, the
    outline, the state, and the specialised goals in full and of the state alone say, as
    [State, Low, High, Miss] or [State], or the error that came instead.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(library(readutil)).
:- use_module(library(http/json)).

serve :-
    repeat,
    read_term(user_input, Term, []),
    (   Term == end_of_file
    ->  true
    ;   Term = scene(Facts, Words, Crisp, Tests),
        answers(Facts, Words, Crisp, Tests, Rows),
        json_write_dict(user_output, Rows, [width(0)]),
        nl(user_output),
        flush_output(user_output),
        fail
    ).

answers(Facts, Words, Crisp, Tests, Rows) :-
    facetlog_scene:new_scene(oracle),
    facetlog_facts_on_demand:prepare_facts(oracle),
    forall(member(Fact, Facts), assertz(oracle:Fact)),
    forall(( schema:fact_schema(Name/Arity, _), functor(Head, Name, Arity) ),
           facetlog_target:declared(oracle, Head)),
    retractall(words:means(_, _)),
    forall(member(Word-Meaning, Words), assertz(words:means(Word, Meaning))),
    nb_setval(facetlog_crisp, Crisp),
    b_setval(facetlog_scene, oracle),
    maplist(row(Crisp), Tests, Rows),
    facetlog_target:forget_code(oracle),
    facetlog_scene:destroy_scene(oracle).

row(Crisp, Test, [Proof, Outline, State, Full, Specialised]) :-
    said(facetlog_prove:evaluate(Test, words, proof(S1, L1, H1, _, _, _)), [S1, L1, H1], Proof),
    said(facetlog_say:outline(Test, words, outline(S2, L2, H2, M2)), [S2, L2, H2, M2], Outline),
    said(facetlog_say:state(Test, words, S3), [S3], State),
    specialised(Test, full, Crisp, said(S4, degree(L4, H4, M4)), [S4, L4, H4, M4], Full),
    specialised(Test, state, Crisp, said(S5, none), [S5], Specialised).

%   The faces of a test are known when it is asked, not when it is written.
specialised(Test0, Want, Crisp, Said, Answer, Row) :-
    Names = [f1, f2, f3, f4, t1],
    length(Variables, 5),
    pairs_keys_values(Pairs, Names, Variables),
    with_variables(Test0, Pairs, Test),
    said(( facetlog_partial:said_code(Test, Want, context(words, oracle, Crisp), Said, Code),
           flag(tests, Number, Number + 1),
           facetlog_target:helper(context(words, oracle, Crisp), test(Number), [Variables, Said],
                                  Head, _),
           assertz(oracle:(Head :- Code)),
           Variables = Names,
           call(oracle:Head) ), Answer, Row).

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

said(Goal, Answer, Row) :-
    catch(( call(Goal) -> Row = Answer ; Row = [failed] ), Error, error_row(Error, Row)).

error_row(error(Formal, _), [error, Text]) :- !, term_string(Formal, Text).
error_row(Error, [error, Text]) :- term_string(Error, Text).
