% What is specialised asks for the facts of its models and no others (who falls back asks for all), and says
% of them what any scene says.
:- use_module(library(plunit)).
:- use_module(facetlog_kb(batch)).
:- use_module(facetlog_kb(code)).
:- use_module(facetlog_kb(judge)).
:- use_module(facetlog_kb(loader)).
:- use_module(facetlog_kb(named_models)).
:- use_module(facetlog_kb(loader)).
:- use_module(facetlog_kb(scene)).

% Facts that each model asks for beside those of a face and its thing.
needs([ condition(m, a, "", _, [A, _], at_least(fill(A), 0.5)) ], [fill/3]).
needs([ condition(m, a, "", _, [A, _], at_least(fill(A) - share(A), 0.1)) ], [fill/3, share/3]).
needs([ condition(m, a, "", _, [A, B], near(angle(A, B), 90, 5*(fill(A) + 1))) ], [angle/4, fill/3]).
needs([ condition(m, a, "", T, [A, B], any([whole(T), implies(adjoins(A, B), upward(A))])) ],
      [adjoins/3, tilt/3, upward/1, whole/1]).
needs([ condition(m, a, "", _, [A, B], each_pair(X, Y, [A, B], if_known(not(convex(X, Y))))) ],
      [concave/2, convex/2]).
needs([ condition(m, a, "", _, [A, B], expect(0.5, at_least_of(1, X, [[A], [B]], opposite(X, A)))) ],
      [opposite/2]).
needs([ ( condition(m, a, "", T, [A, B], some(F, Fs, at_most(share(F), 0.3))) :-
              findall(F, ( face_of(T, F), \+ memberchk(F, [A, B]), possible(adjoins(F, A)) ), Found),
              sort(Found, Fs) ) ],
      [adjoins/3, share/3]).
needs([ ( condition(m, a, "", T, [A, B], at_least_of(1, F, Gs, short(F, A))) :-
              members(T, A, B, Fs), separate(Fs, Gs) ),
        means(short(F, A), fading(at_most(protrusion(F), metres(0.1)), 0.1*width(A))),
        ( members(T, A, B, Fs) :-
              findall(F, ( face_of(T, F), \+ memberchk(F, [A, B]), possible(opposite(F, B)) ), Found),
              sort(Found, Fs) ) ],
      [adjoins/3, corner/3, edge/3, offset/4, on_ground/1, opposite/2, point/4, protrusion/3, scale/1, thing_size/4, tilt/3,
       up/3, width/3]).
needs([ ( condition(m, a, "", T, [_, _], each_pair(X, Y, Fs, if_known(not(convex(X, Y))))) :-
              findall(F, face_of(T, F), Fs) ) ],
      [concave/2, convex/2]).
needs([ ( condition(m, a, "", _, [A, B], convex(A, B)) :- holds(at_most(fill(A), fill(B))) ) ],
      [concave/2, convex/2, fill/3]).
needs([ ( size(m, _, [A, B], long, Longest) :-
              longest_first([dihedral(A, B), angle(A, B)], [Longest|_]) ) ],
      [angle/4, dihedral/4]).
needs([ ( size(m, _, [A, _], wide, protrusion(A)) ) ], [protrusion/3]).
needs([ ( group(m, T, [A, B], others, Fs) :-
              findall(F, ( face_of(T, F), \+ memberchk(F, [A, B]), possible(coplanar(F, A)) ), Found),
              sort(Found, Fs) ) ],
      [coplanar/2]).

% Bodies with control, closures and predicates of their own.
needs([ ( condition(m, a, "", T, [A, _], some(F, Fs, upward(F))) :-
              findall(F, face_of(T, F), All), include(broad, All, Broad), exclude(==(A), Broad, Fs) ),
        ( broad(F) :- holds(at_least(share(F), 0.4)) ) ],
      [share/3, tilt/3, upward/1]).
needs([ ( condition(m, a, "", _, [_, _], some(F, Fs, upward(F))) :- findall(F, face_of(_, F), Fs) ) ],
      [tilt/3, upward/1]).
needs([ ( condition(m, a, "", T, [_, _], at_least(count(Fs), 2)) :-
              ( setof(F, A^B^between(T, A, F, B), Fs) -> true ; Fs = [] ) ),
        ( between(T, A, F, B) :-
              face_of(T, A), face_of(T, F), face_of(T, B), A @< B, holds(adjoins(F, A)), holds(adjoins(F, B)) ) ],
      [adjoins/3]).
needs([ ( condition(m, a, "", T, [_, _], at_least(share(F), 0.3)) :-
              findall(F0, face_of(T, F0), Fs), foldl(larger, Fs, none, F) ),
        larger(F, none, F),
        ( larger(F, G, H) :- G \== none, ( holds(at_least(fill(F), fill(G))) -> H = F ; H = G ) ) ],
      [fill/3, share/3]).
needs([ ( condition(m, a, "", _, [A, B], upward(A)) :- forall(member(F, [A, B]), possible(whole(F))) ) ],
      [tilt/3, upward/1, whole/1]).
needs([ ( condition(m, a, "", _, [A, B], upward(B)) :-
              \+ holds(convex(A, B)), ( holds(whole(t1)) ; possible(upward(A)) *-> true ) ) ],
      [concave/2, convex/2, tilt/3, upward/1, whole/1]).
needs([ ( condition(m, a, "", T, [A, _], at_least(count(Fs), 3)) :-
              largest_faces(T, Fs), aggregate_all(count, member(A, Fs), N), N > 0 ) ],
      [area/3]).
needs([ ( size(m, _, [A, B], short, Shortest) :-
              longest_first([protrusion(A), width(B)], Sorted), last(Sorted, Shortest) ) ],
      [protrusion/3, thing_size/4, width/3]).
needs([ ( size(m, _, [A, B], gap, 2*width(A) - protrusion(B)/2) ) ],
      [protrusion/3, thing_size/4, width/3]).

needs([ condition(m, a, "", _, [A, _], at_least(fill(A), 0.5)),
        ( measured(own(F), V, 0, ratio) :- measure(share(F), V, _, _) ) ],
      [fill/3]).
needs([ condition(m, a, "", _, [A, _], upward(A)), condition(m, a, "", _, [_, B], upward(B)) ], [tilt/3, upward/1]).
needs([ condition(m, a, "", _, [A, _], upward(A)), condition(m, a, "", _, [A, _], upward(A)) ], [tilt/3, upward/1]).
needs([ condition(m, a, "", T, [A, _], any([whole(T), upward(A)])), condition(m, a, "", T, [_, B], any([whole(T), upward(B)])) ],
      [tilt/3, upward/1, whole/1]).
needs([ ( condition(m, a, "", T, [A, B], opposite(A, B)) :- faces(T, A, Fs), separate(Fs, Groups) ),
        ( faces(T, A, Fs) :- findall(F, ( face_of(T, F), \+ memberchk(F, [A]) ), Found), sort(Found, Fs) ) ],
      [adjoins/3, corner/3, edge/3, offset/4, on_ground/1, opposite/2, point/4, thing_size/4, tilt/3, up/3]) :-
    member(Groups, [[_], [_, _]]).
needs([ ( condition(m, a, "", T, [A, B], Test) :- members(T, A, B, Fs), separate(Fs, Gs) ),
        ( members(T, A, B, Fs) :-
              findall(F, ( face_of(T, F), \+ memberchk(F, [A, B]), possible(coplanar(F, A)) ), Found),
              sort(Found, Fs) ) ],
      [adjoins/3, coplanar/2, corner/3, edge/3, offset/4, on_ground/1, opposite/2, point/4, thing_size/4,
       tilt/3, up/3, upward/1]) :-
    Some = at_least_of(1, X, Gs, opposite(X, B)),
    member(Form, [ Some, all([opposite(A, B), Some, opposite(B, A)]), any([opposite(A, B), Some]), any([Some, Some]),
                   not(Some), if_known(Some), expect(0.5, Some), implies(opposite(A, B), Some),
                   implies(Some, opposite(A, B)) ]),
    Test = all([upward(A), Form]).
needs([ ( size(m, _, [A, B], long, Longest) :-
              longest_first([tolerance(twice)*width(A), protrusion(B)], [Longest|_]) ),
        tolerance(twice, 2) ],
      [protrusion/3, thing_size/4, width/3]).

% A scene with four faces of a thing, of which each fact is known of some.
stated(thing(t1)).
stated(whole(t1)).
stated(scale(metric)).
stated(up(0.0, 0.0, 1.0)).
stated(Fact) :-
    nth0(Number, [f1, f2, f3, f4], F),
    Sd is 0.01*Number,
    One is 0.2 + 0.1*Number,
    Other is 0.7 - 0.1*Number,
    Area is One*Other,
    member(Fact, [ face(F), part_of(F, t1), evidence(F, measured), area(F, Area, Sd), width(F, One, Sd),
                   protrusion(F, Other, Sd), share(F, One, Sd), fill(F, Other, Sd) ]).
stated(upward(f2)).
stated(tilt(f1, 80.0, 1.0)).
stated(tilt(f4, 5.0, 1.0)).
stated(Fact) :-
    member(A-B-Angle, [f1-f2-89.0, f1-f3-45.0, f2-f4-91.0]),
    member(X-Y, [A-B, B-A]),
    member(Fact, [angle(X, Y, Angle, 1.0), dihedral(X, Y, Angle, 1.0), adjoins(X, Y, e1)]).
stated(Fact) :-
    member(Fact, [convex(f1, f2), convex(f2, f1), concave(f2, f3), concave(f3, f2), opposite(f3, f4), opposite(f4, f3),
                  coplanar(f1, f4), coplanar(f4, f1)]).

with_rules(Clauses, Rules, Goal) :-
    facetlog_bridge:ask_base(specialised, all),
    gensym(specialised, Rules),
    setup_call_cleanup(
        new_rule_module(Rules),
        ( dynamic(Rules:condition/6),
          forall(member(Clause, [ model(m, "", [a, b]),
                                  ( candidate(m, Thing, [One, Other]) :-
                                        face_of(Thing, One), face_of(Thing, Other),
                                        One @< Other )|Clauses ]),
                 assertz(Rules:Clause)),
          name_models(specialised, [m], Rules),
          once(Goal) ),
        ( unname_models(specialised, Rules), '$destroy_module'(Rules) )).

asked(Clauses, Asked) :-
    gensym(batch, Batch),
    with_rules(Clauses, Rules,
               ( open_code(Batch, [Rules-[m]], All), close_code(Batch) )),
    findall(Name/Arity,
            ( member(Name-Arity, All), \+ memberchk(Name, [thing, face, part_of, evidence]) ),
            Asked).

% The verdict in outline: in a batch that has the facts which it asks for, and in a scene with all.
in_batch(Rules, Outline) :-
    gensym(batch, Batch),
    open_code(Batch, [Rules-[m]], Asked),
    forall(( stated(Fact), functor(Fact, Name, Arity), memberchk(Name-Arity, Asked) ), assertz(Batch:Fact)),
    brief_verdicts(Batch, 100_000_000, [brief(m, t1, State, Low, High, Parts, Sizes, _)]),
    close_code(Batch),
    Outline = outline(State, Low, High, Parts, Sizes).

in_full(Rules, outline(State, Low, High, Parts, Sizes)) :-
    gensym(scene, Scene),
    setup_call_cleanup(
        new_scene(Scene),
        ( forall(stated(Fact), assertz(Scene:Fact)),
          in_scene(Scene, judge(Rules, m, t1, Verdict)) ),
        destroy_scene(Scene)),
    Verdict = verdict(_, _, State, Low, High, Parts, Sizes0, _, _, _),
    findall(size(Name, V, Sd), member(size(Name, V, Sd, _), Sizes0), Sizes).

% Of what has no degree a batch has no near miss.
refused(outline(fails, 0, 0, [], []), outline(fails, _, High, _, _)) :- High < 0.001.

:- begin_tests(specialised).

test(facts_asked_for, forall(needs(Clauses, Facts))) :-
    asked(Clauses, Asked),
    assertion(Clauses-Asked == Clauses-Facts).
test(same_verdict, forall(needs(Clauses, _))) :-
    with_rules(Clauses, Rules, ( in_batch(Rules, Brief), in_full(Rules, Full) )),
    assertion(( Brief == Full ; refused(Brief, Full) )).
test(what_cannot_be_seen_through_is_called_as_it_is, Members == [f1, f2, f3, f4]) :-
    with_rules([ condition(m, a, "", _, [_, _], all([])),
                 ( group(m, T, [_, _], others, Fs) :- G = face_of(T, F), findall(F, G, Fs) ) ],
               Rules, in_batch(Rules, outline(_, _, _, Parts, _))),
    memberchk(group(others, Members), Parts).
test(asks_for_any_fact, forall(member(Clause,
        [ condition(m, a, "", T, [_, _], is_a(T, m)),
          ( condition(m, a, "", _, [A, _], Test) :- member(Test, [upward(A)]) ),
          ( condition(m, a, "", _, [A, _], at_least(Measure, 1)) :- member(Measure, [fill(A)]) ),
          ( condition(m, a, "", _, [A, B], upward(A)) :- each_pair(A, _, [A, B], adjoins(A, B)) ),
          ( condition(m, a, "", T, [A, _], upward(A)) :- part_in(T, m, a, _) ),
          ( condition(m, a, "", _, [A, _], upward(A)) :- member(Fact, [whole(t1)]), fact(Fact) ),
          ( candidate(m, T, [A, B]) :- member(Steps, [[step(A, 1, upward(A)), step(B, 1, upward(B))]]),
                                       as_far_as_seen(T, Steps, [A, B]) ),
          ( condition(m, a, "", _, [A, B], upward(A)) :-
                Measures = [width(A), width(B)], longest_first(Measures, _) ),
          ( size(m, _, [A, _], wide, Measure) :- Measures = [width(A)], member(Measure, Measures) ),
          ( size(m, _, [A, B], long, Longest) :-
                Measures = [width(A), width(B)], longest_first(Measures, [Longest|_]) ) ]))) :-
    asked([Clause], Asked),
    length(Asked, Count),
    assertion(Count > 50).

% The labels of conditions of two parts whose outlines are kept for fewer.
kept_for_fewer([ condition(m, kept, "", _, [A, _], upward(A)),
                 condition(m, kept_too, "", T, [_, B], any([whole(T), upward(B)])),
                 condition(m, of_all, "", _, [A, B], adjoins(A, B)),
                 condition(m, of_none, "", _, [_, _], all([])) ],
               [kept, kept_too]).

test(kept_for_those_that_it_depends_on) :-
    kept_for_fewer(Clauses, Expected),
    gensym(batch, Batch),
    with_rules(Clauses, Rules,
               ( open_code(Batch, [Rules-[m]], _),
                 findall(Label, facetlog_target:made(Batch, kept(m, Label, _, _, _), _, _, _), Labels),
                 close_code(Batch) )),
    assertion(Labels == Expected).
test(members_of_a_group_are_found_once, Lists == [2]) :-
    gensym(batch, Batch),
    with_rules([ ( group(m, T, [A, B], others, Fs) :-
                       findall(F, ( face_of(T, F), \+ memberchk(F, [A, B]), possible(coplanar(F, A)) ), Found),
                       sort(Found, Fs) ) ], Rules,
               ( open_code(Batch, [Rules-[m]], _),
                 findall(Count, ( facetlog_target:made(Batch, listed(sorted, _, Of, _, _), _, _, _), length(Of, Count) ), Lists),
                 close_code(Batch) )).
test(what_searches_for_nothing_is_asked_together, Mosts == [2, 1]) :-
    gensym(batch, Batch),
    with_rules([ condition(m, a, "", _, [A, _], upward(A)), condition(m, b, "", _, [_, B], upward(B)),
                 ( condition(m, c, "", _, [C, _], upward(C)) :- possible(whole(t1)) ) ], Rules,
               ( open_code(Batch, [Rules-[m]], _), call(Batch:plan, m, Plan), close_code(Batch) )),
    length(Plan, Count),
    findall(Of, ( member(group(_, Name, _), Plan), ( sub_atom(Name, 0, _, _, 'lines#') -> Of = 2 ; Of = 1 ) ),
            Mosts),
    assertion(Count == 2).
test(what_searches_is_asked_alone, Count == 1) :-
    gensym(batch, Batch),
    with_rules([ ( condition(m, c, "", _, [C, _], upward(C)) :- possible(whole(t1)) ) ], Rules,
               ( open_code(Batch, [Rules-[m]], _), call(Batch:plan, m, Plan), close_code(Batch) )),
    length(Plan, Count).
test(one_condition_is_left_to_the_interpreter, Models == [conditions(m, 2, [other])]) :-
    gensym(batch, Batch),
    with_rules([ condition(m, own, "", _, [A, _], upward(A)), condition(m, other, "", T, [_, _], is_a(T, m)) ], Rules,
               ( open_code(Batch, [Rules-[m]], _), batch_conditions(Batch, Models), close_code(Batch) )).
test(condition_for_what_it_is_not_of, Brief == Full) :-
    with_rules([ condition(m, own, "", t2, [A, _], upward(A)), condition(m, other, "", t2, [_, f3], is_a(t2, m)),
                 condition(m, some, "", _, [_, f3], all([])) ], Rules,
               ( in_batch(Rules, Brief), in_full(Rules, Full) )).

:- end_tests(specialised).

:- begin_tests(put_off).

% Where within a test the code stands that finds Fs.
within(all([a, b(Fs), c]), Fs, all([a, after(code, b(Fs)), c])).
within(any([a, b(Fs), c]), Fs, any([a, after(code, b(Fs)), c])).
within(not(b(Fs)), Fs, not(after(code, b(Fs)))).
within(if_known(b(Fs)), Fs, if_known(after(code, b(Fs)))).
within(expect(0.5, b(Fs)), Fs, expect(0.5, after(code, b(Fs)))).
within(implies(a, b(Fs)), Fs, implies(a, after(code, b(Fs)))).
within(all([a, any([b(Fs), c])]), Fs, all([a, any([after(code, b(Fs)), c])])).
within(implies(b(Fs), c), Fs, after(code, implies(b(Fs), c))).
within(implies(b(Fs), b(Fs)), Fs, after(code, implies(b(Fs), b(Fs)))).
within(all([a, b(Fs), c(Fs)]), Fs, after(code, all([a, b(Fs), c(Fs)]))).
within(any([b(Fs), c(Fs)]), Fs, after(code, any([b(Fs), c(Fs)]))).
within(all([b(Fs)|Rest]), Fs, after(code, all([b(Fs)|Rest]))).
within(all(Fs), Fs, after(code, all(Fs))).
within(Fs, Fs, after(code, Fs)).
within(some(x, Fs, c), Fs, after(code, some(x, Fs, c))).

test(within_the_test, forall(within(Test, Found, Expected))) :-
    facetlog_specialise:placed(Test, Found, code, Placed),
    assertion(Placed == Expected).

% What is left of steps and a test where the faces are found once for those that the test asks for.
left(Steps0, Test0, Steps, Test) :-
    gensym(put_off, Target),
    setup_call_cleanup(
        new_rule_module(Target),
        facetlog_specialise:put_off(Steps0, scope(_, [_], []), context(vocabulary, Target, false), Test0, Steps, Test),
        ( facetlog_target:forget_code(Target), '$destroy_module'(Target) )).

test(found_when_the_test_asks, Steps-Test =@= []-all([a, after(Code, some(x, Fs, c))])) :-
    left([source(F, [face_of(_, F)], [_], all([]), Fs)], all([a, some(x, Fs, c)]), Steps, Test),
    Test = all([_, after(Code, _)]).
test(not_found_if_nobody_asks, Steps-Test == []-a) :-
    left([source(F, [face_of(_, F)], [_], all([]), _)], a, Steps, Test).
test(groups_after_what_they_group, Steps-Test =@= []-all([a, after(Code1, after(Code2, some(x, Gs, c)))])) :-
    left([source(F, [face_of(_, F)], [_], all([]), Fs), separate(Fs, Gs)], all([a, some(x, Gs, c)]), Steps, Test),
    Test = all([_, after(Code1, after(Code2, _))]),
    term_variables(Code1, Variables),
    assertion(( member(Variable, Variables), Variable == Fs )).
test(other_steps_stay, Steps =@= [Source, holds(a(Fs))]) :-
    Source = source(F, [face_of(_, F)], [_], all([]), Fs),
    left([Source, holds(a(Fs))], some(x, Fs, c), Steps, _).

:- end_tests(put_off).
