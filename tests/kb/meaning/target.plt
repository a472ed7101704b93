% The module that rules are specialised into: what is made once, copied, forgotten, and remembered of a scene.
:- use_module(library(plunit)).
:- use_module(library(lists)).
:- use_module(facetlog_kb(target)).
:- use_module(facetlog_kb(loader)).
:- use_module(facetlog_kb(body_code)).

:- meta_predicate in_target(0, ?).

in_target(Goal, Context) :-
    gensym(target, Target),
    Context = context(user, Target, false),
    setup_call_cleanup(
        new_rule_module(Target),
        once(Goal),
        ( forget_code(Target), '$destroy_module'(Target) )).

:- begin_tests(target).

test(one_predicate_for_what_is_alike, News-Same == [true, false, true, true]-true) :-
    in_target(( helper(C, of(X, f), [X, a], One, N1), helper(C, of(Y, f), [Y, b], Two, N2),
                helper(C, of(f, Y), [Y, b], _, N3), helper(C, of(Y, f), [Y], _, N4) ), C),
    News = [N1, N2, N3, N4],
    ( One =.. [Name, X, a], Two =.. [Name, Y, b] -> Same = true ; Same = false ).
test(what_was_begun_is_forgotten, News == [false, true]) :-
    in_target(( helper(C, before, [], _, _),
                \+ attempt(C, stop(_), ( helper(C, key, [], _, _), throw(stop(here)) )),
                helper(C, before, [], _, N1), helper(C, key, [], _, N2) ), C),
    News = [N1, N2].
test(copies_that_were_begun_are_forgotten, Copied == [a/1]) :-
    in_target(( C = context(_, Target, _), copy_noted(Target, a/1),
                \+ attempt(C, stop, ( copy_noted(Target, b/1), throw(stop) )),
                findall(Copy, copied(Target, Copy), Copied) ), C).
test(what_succeeds_is_kept, X-New == 1-false) :-
    in_target(( call_cleanup(attempt(C, stop, ( helper(C, key, [], _, _), member(X, [1, 2]) )), Only = true),
                assertion(Only == true), helper(C, key, [], _, New) ), C).
test(what_is_noted_of_a_target_can_be_noted_of_another,
     Notes-Again-Rows-Left == Noted-Noted-[0, 0, saved/0]-[]) :-
    in_target(( noted(C, Target, Name, Known),
                code_notes(Target, Notes),
                C2 = context(user, Other, _),
                in_target(( facetlog_target:declared(Other, Known),
                            assertz(Other:Known),
                            note_again(Other, Notes),
                            code_notes(Other, Again),
                            findall(Number, facetlog_target:copy(Other, _, Number), Copies),
                            findall(Number, facetlog_target:made(Other, _, _, _, Number), Mades),
                            findall(Key/Number, facetlog_target:made(Other, Key, _, _, Number), Keys),
                            append([Copies, Mades, Keys], Rows),
                            forget_remembered(Other),
                            findall(Known, Other:Known, Left) ), C2) ), C),
    functor(Known, KnownName, KnownArity),
    Noted = [asks(face/1), copy(a/1), made(Name/2), remembered(KnownName/KnownArity)].
test(other_errors_pass, throws(other)) :-
    in_target(attempt(C, stop, throw(other)), C).

% A target of which something of each kind is noted; Known is what is remembered of a scene.
noted(C, Target, Name, Known) :-
    note_of(C, Target),
    copy_noted(Target, a/1),
    remembering(C, Target, Head, _, _),
    functor(Head, Name, 2),
    facetlog_target:remembered(Target, Known),
    Known =.. [_|Args],
    maplist(=(1), Args).

note_of(context(_, Target, _), Target) :-
    note(Target, face/1).

% A predicate that counts how often its body runs.
remembering(C, Target, Head, X, Y) :-
    C = context(_, Target, _),
    helper(C, counting, [X, Y], Head, true),
    put_remembered(C, Head, [X], [Y], user:counted(X, Y)).

test(worked_out_once_a_scene, Found-Count == [1-1, 1-1, 2-none]-2) :-
    flag(target_asked, _, 0),
    in_target(( remembering(C, Target, Head, X, Y),
                findall(X-Found1, ( member(X, [1, 1, 2]), ( call(Target:Head) -> Found1 = Y ; Found1 = none ) ), Found) ),
              C),
    flag(target_asked, Count, Count).
test(for_the_next_scene_again, Count == 2) :-
    flag(target_asked, _, 0),
    in_target(( remembering(C, Target, Head, 1, _), forall(member(_, [a, b]), ( call(Target:Head), forget_remembered(Target) )) ),
              C),
    flag(target_asked, Count, Count).
test(not_remembered_of_what_is_not_known, Answers == [1, 1]) :-
    in_target(( remembering(C, Target, Head, X, Y),
                findall(Y, ( member(_, [a, b]), \+ \+ call(Target:Head), ( X = 1, call(Target:Head) ) ), Answers) ), C).
test(as_one_call, Codes == [f(a), true]) :-
    in_target(( called(f(a), f(a), C, Code), called(( f(X), g(X, _) ), X, C, Call) ), C),
    Codes = [Code, One],
    ( Call =.. [_, Y], Y == X -> One = true ; One = Call ).
test(control_is_called_as_one, forall(member(Code, [ ( a, b ), ( a ; b ), ( a -> b ), ( a *-> b ), \+ a ]))) :-
    in_target(( called(Code, [], C, Call), called(Code, [], C, Again), Again == Call, C = context(_, Target, _), clause(Target:Call, Body) ), C),
    assertion(Body == Code).

% Whether code for these goals leaves something to the modules that judge any test.
interpreting(facetlog_say:said(t, user, state, _), true).
interpreting(facetlog_search:outlines(_, _, _, _, _, _), true).
interpreting(facetlog_quantities:value(_, user, _), true).
interpreting(facetlog_quantities:longest_first_in(user, _, _), true).
interpreting(measures:measure(_, _, _, _), true).
interpreting(( a, ( b -> facetlog_say:said(_, _, _, _) ; true ) ), true).
interpreting(facetlog_degrees:joint_miss(_, _), false).
interpreting(lists:member(_, [said(_, _, _, _)]), false).
interpreting(said(_, _, _, _), false).

test(what_is_interpreted, forall(interpreting(Goal, Expected))) :-
    in_target(( helper(C, inner, [], Inner, true), helper(C, outer, [X], Outer, true),
                put_clause(C, ( Inner :- X = 1, Goal )), put_clause(C, ( Inner :- Outer )),
                put_clause(C, ( Outer :- findall(x, Inner, X) )),
                C = context(_, Target, _), functor(Outer, Name, 1),
                ( calls_interpreter(Target, Name/1) -> Found = true ; Found = false ) ), C),
    assertion(Goal-Found == Goal-Expected).
test(facts_that_are_asked_for, Asked == [a/1, b/2]) :-
    in_target(( C = context(_, Target, _), note(Target, a/1), note(Target, b/2), note(Target, a/1),
                findall(Fact, asked_of_scene(Target, Fact), Asked) ), C).
test(all_is_forgotten, Left == []) :-
    in_target(( C = context(_, Target, _), copy_noted(Target, a/1), note(Target, b/1), helper(C, key, [X], Head, _),
                put_remembered(C, Head, [X], [], true) ), C),
    findall(Note,
            ( member(Note, [ asks(Target, _), copy(Target, _, _), made(Target, _, _, _, _), remembered(Target, _) ]),
              call(facetlog_target:Note) ),
            Left).
test(any_fact, Asked == All) :-
    in_target(( C = context(_, Target, _), note(Target, a/1), asks_all(C), findall(Fact, asked_of_scene(Target, Fact), Asked) ), C),
    findall(Fact, schema:fact_schema(Fact, _), All).
test(where_a_goal_is_called, Codes == [lists:append(a, b, c), length(a, b), user:own(a)]) :-
    maplist([Goal, Code]>>placed(Goal, user, Code), [append(a, b, c), length(a, b), own(a)], Codes).

:- end_tests(target).

counted(1, 1) :- flag(target_asked, N, N + 1).
counted(2, _) :- flag(target_asked, N, N + 1), fail.

:- begin_tests(copies).

% What a predicate of the program becomes; whether its answers are kept for the scene.
copied_as(vocabulary:largest_faces(_, _), 'vocabulary:largest_faces'(_, _), kept).
copied_as(vocabulary:face_of(_, _), 'vocabulary:face_of'(_, _), kept).
copied_as(vocabulary:element_of(_, _), 'vocabulary:element_of'(_, _), kept).
copied_as(grouping:separate(_, _), 'grouping:separate'(_, _), kept).
copied_as(grouping:narrow_foot(_, _), 'grouping:narrow_foot'(_, _), kept).
copied_as(line_labels:labels_of_view(_, _), 'line_labels:labels_of_view'(_, _), kept).
copied_as(vocabulary:shared_edge(_, _, _), 'vocabulary:shared_edge'(_, _, _), anew).

test(copies, forall(copied_as(Goal, Copy, How))) :-
    in_target(( body_code(Goal, C, Code), functor(Code, Name, Arity), atom_concat(Name, ' anew', Anew),
                C = context(_, Target, _), copied(Target, Name/Arity),
                ( current_predicate(Target:Anew/Arity) -> Found = kept ; Found = anew ) ), C),
    Goal = _:Plain,
    Plain =.. [_|Args],
    Copy =.. [_|Args],
    assertion(Code == Copy),
    assertion(Found == How).
test(goal_has_one_code, forall(member(Goal, [ true, !, fact(whole(t)), possible(upward(_)), holds(upward(_)),
                                              chosen([T], X, [face_of(T, X)]), among_chosen([T], X, [face_of(T, X)]),
                                              as_far_as_seen(T, [step(X, 1, upward(X))], [X]),
                                              longest_first([width(X)], _), measure(width(X), _, _, _), ( a, b ),
                                              ( a -> b ; c ), ( a *-> b ), \+ a, recall(_, _, _, _, _, true),
                                              findall(X, face_of(T, X), _), include(==(X), _, _),
                                              setof(X, T^face_of(T, X), _), face_of(T, X), atom(X), part_in(T, _, _, _) ]))) :-
    in_target(( call_cleanup(body_code(vocabulary:Goal, C, _), Only = true), assertion(Only == true) ), C).
test(state_that_is_known, Codes == [true, true, true, fail, fail, fail]) :-
    findall(Code,
            ( member(Test, [all([]), each(X, [], adjoins(X, unseen)), any([])]),
              member(Goal, [possible(Test), holds(Test)]),
              in_target(body_code(vocabulary:Goal, C, Code), C) ),
            Codes).
test(what_cannot_be_seen_through, forall(member(Goal, [ _, in(_, _), possible(_), holds(_), maplist(_, _),
                                                        maplist(_:atom, _), maplist([X]>>atom(X), _) ]))) :-
    catch(in_target(body_code(vocabulary:Goal, C, _), C), facetlog_general(_), Thrown = true),
    assertion(Thrown == true).
test(measure_of_one_fact, Code == fill(a, V, Sd)) :-
    in_target(body_code(measures:measure(fill(a), V, Sd, ratio), C, Code), C).
test(measure_of_a_kind_that_is_not_known, throws(facetlog_unknown(lowest(_)))) :-
    in_target(facetlog_first_answer:first_answer_code(lowest(_), _, _, _, C, _), C).
test(measure_is_made_once, Made == 2) :-
    in_target(( body_code(measures:measure(count(_), _, _, count), C, _),
                body_code(measures:measure(count(_), _, _, count), C, _),
                C = context(_, Target, _),
                aggregate_all(count,
                              ( facetlog_target:made(Target, measure(_), Arity, Name, _), functor(Head, Name, Arity),
                                clause(Target:Head, _) ),
                              Made) ), C).
test(fact_of_a_measure_is_asked_first, First == width(A, V, Sd)) :-
    in_target(body_code(measures:measure(width(A), V, Sd, length), C, Code), C),
    Code = ( First -> true ; _ ).
test(list_is_made_once, Made == 2) :-
    in_target(( listed_code(as_found, [T], X, [face_of(T, X)], vocabulary, C, _, Code),
                listed_code(as_found, [U], Y, [face_of(U, Y)], vocabulary, C, _, Code1),
                C = context(_, Target, _), functor(Code, Name, 2), functor(Code1, Name, 2), functor(Head, Name, 2),
                aggregate_all(count, clause(Target:Head, _), Made) ), C).
test(faces_of_a_join_are_found_by_pairs, Inputs == 2) :-
    assertz(user:( joined_faces(T, A, B) :- face_of(T, A), face_of(T, B), possible(adjoins(A, B)) )),
    in_target(( body_code(user:joined_faces(_, _, _), C, _), C = context(_, Target, _),
                facetlog_target:made(Target, listed(as_found, user, Of, _, [_, possible(_)]), _, _, _) ), C),
    length(Of, Inputs).
test(steps_of_a_goal, Goals == [a, b, X, c]) :-
    conjuncts(( true, a, ( b, true, X ), c ), Goals).
test(goal_of_steps, Codes == [true, a, ( a, b ), ( a, b, c )]) :-
    maplist(conjunction, [[true, true], [true, a, true], [a, b], [a, ( b, c )]], Codes0),
    maplist([Code0, Code]>>( conjuncts(Code0, Steps), right(Steps, Code) ), Codes0, Codes).

right([], true).
right([Goal|Goals], Code) :- ( Goals == [] -> Code = Goal ; Code = ( Goal, Code1 ), right(Goals, Code1) ).

:- end_tests(copies).
