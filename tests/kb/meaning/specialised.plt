% What is specialised asks for the facts of its models and no others: who falls back asks for all.
:- use_module(library(plunit)).
:- use_module(facetlog_kb(batch)).
:- use_module(facetlog_kb(rule_module)).
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
      [adjoins/3, corner/3, edge/3, opposite/2, point/4, protrusion/3, scale/1, thing_size/4, up/3,
       width/3]).
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

asked(Clauses, Asked) :-
    gensym(specialised, Rules),
    gensym(batch, Batch),
    setup_call_cleanup(
        new_rule_module(Rules),
        ( forall(member(Clause, [ model(m, "", [a, b]),
                                  ( candidate(m, Thing, [One, Other]) :-
                                        face_of(Thing, One), face_of(Thing, Other),
                                        One @< Other )|Clauses ]),
                 assertz(Rules:Clause)),
          open_batch(Batch, Batch, [Rules-[m]], All),
          findall(Name/Arity,
                  ( member(Name-Arity, All),
                    \+ memberchk(Name, [thing, face, part_of, evidence]) ),
                  Asked),
          close_batch(Batch) ),
        '$destroy_module'(Rules)).

:- begin_tests(specialised).

test(facts_asked_for, forall(needs(Clauses, Facts))) :-
    asked(Clauses, Asked),
    assertion(Clauses-Asked == Clauses-Facts).
test(what_another_model_says_is_not_seen_through, true(Count > 50)) :-
    asked([condition(m, a, "", T, [_, _], is_a(T, m))], Asked),
    length(Asked, Count).
test(test_that_is_a_variable_is_not_seen_through, true(Count > 50)) :-
    asked([( condition(m, a, "", _, [A, _], Test) :- member(Test, [upward(A)]) )], Asked),
    length(Asked, Count).

:- end_tests(specialised).
