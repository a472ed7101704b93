% Which faces are found once for the thing, or for few parts, and which again for each choice.
:- use_module(library(plunit)).
:- use_module(facetlog_kb(joins)).
:- use_module(facetlog_kb(sources)).
:- use_module(facetlog_kb(body_code)).
:- use_module(facetlog_kb(target)).
:- use_module(facetlog_kb(loader)).

:- begin_tests(joins).

% A body, and its steps by pairs.
by_pairs_of(Body0, Steps) :-
    by_pairs(Body0, Body),
    conjuncts(Body, Steps).

test(what_is_asked_of_a_face_alone_and_with_another, Steps =@= Expected) :-
    by_pairs_of(( face_of(T, A), possible(upward(A)),
                  face_of(T, B), A @< B, possible(all([adjoins(A, B), measured(B)])),
                  face_of(T, C), B @< C,
                  possible(all([adjoins(A, C), adjoins(B, C), convex(A, B), measured(C)])),
                  possible(square(A, B, C)), possible(whole(T)) ), Steps),
    Bs = chosen([T], B, [face_of(T, B), possible(measured(B))]),
    Cs = chosen([T], C, [face_of(T, C), possible(measured(C))]),
    Expected = [ face_of(T, A), possible(upward(A)),
                 chosen([T, A], B, [Bs, A @< B, possible(adjoins(A, B)), possible(convex(A, B))]),
                 chosen([T, B], C, [Cs, B @< C, possible(adjoins(B, C))]),
                 among_chosen([T, A], C, [Cs, A @< C, possible(adjoins(A, C))]),
                 possible(all([square(A, B, C)])), possible(all([whole(T)])) ].
test(alone_is_enough_where_nothing_is_asked_of_two, Steps =@= Expected) :-
    by_pairs_of(( face_of(T, A), face_of(T, B), A \== B, possible(measured(B)) ), Steps),
    Expected = [ face_of(T, A), chosen([T], B, [face_of(T, B), possible(measured(B))]), A \== B ].
test(order_alone, Steps =@= Expected) :-
    by_pairs_of(( face_of(T, A), face_of(T, B), face_of(T, C), A @< C ), Steps),
    Expected = [ face_of(T, A), face_of(T, B), chosen([T, A], C, [face_of(T, C), A @< C]) ].
test(orders_of_others, Steps =@= Expected) :-
    by_pairs_of(( face_of(T, A), face_of(T, B), A @< B, face_of(T, C), face_of(T, D), C @< D ), Steps),
    Expected = [ face_of(T, A), chosen([T, A], B, [face_of(T, B), A @< B]),
                 face_of(T, C), chosen([T, C], D, [face_of(T, D), C @< D]) ].
test(what_stays, forall(member(Body, [ true,
                                       ( thing(T), face_of(t, A), face_of(T, _), A @< b ),
                                       ( face_of(T, A), face_of(T, A) ),
                                       ( face_of(T, A), face_of(T, _), possible(_) ),
                                       ( face_of(T, A), Goal, call(Goal, T, A) ) ]))) :-
    conjuncts(Body, Goals),
    by_pairs_of(Body, Steps),
    assertion(Steps == Goals).
test(test_whose_parts_are_not_known, Steps =@= Expected) :-
    by_pairs_of(( face_of(T, A), face_of(T, B), possible(all([convex(A, B)|Tests])) ), Steps),
    Expected = [ face_of(T, A), face_of(T, B), possible(all([all([convex(A, B)|Tests])])) ].

:- end_tests(joins).

:- begin_tests(sources).

search(X, Goals, [findall(X, Goals, Found), sort(Found, _)]).

test(source_with_a_test, Steps =@= [source(F, [face_of(T, F)], [A], adjoins(F, A), Fs), separate(Fs, Gs)]) :-
    search(F, ( face_of(T, F), \+ memberchk(F, [A]), possible(adjoins(F, A)) ), [Found, sort(Same, Fs)]),
    sources([Found, sort(Same, Fs), separate(Fs, Gs)], Steps).
test(several_sources, Steps =@= [fact(whole(T)), source(F, [face_of(T, F)], [A], all([]), Fs),
                                 source(G, [face_of(T, G)], [B], all([]), Gs), separate(Gs, _)]) :-
    search(F, ( face_of(T, F), \+ memberchk(F, [A]) ), [Found1, Sort1]),
    search(G, ( face_of(T, G), \+ memberchk(G, [B]) ), [Found2, Sort2]),
    arg(2, Sort1, Fs),
    arg(2, Sort2, Gs),
    sources([fact(whole(T)), Found1, Sort1, Found2, Sort2, separate(Gs, _)], Steps).
test(source_without, Steps =@= [source(F, [face_of(T, F)], [A, B], all([]), _)]) :-
    search(F, ( face_of(T, F), \+ memberchk(F, [A, B]) ), Goals),
    sources(Goals, Steps).
test(no_source, forall(member(Goal, [ ( face_of(_, F), \+ memberchk(_, [_]) ),
                                      ( face_of(_, F), \+ memberchk(F, _) ),
                                      ( face_of(_, F), !, \+ memberchk(F, [_]) ),
                                      ( face_of(_, F), _, \+ memberchk(F, [_]) ),
                                      ( face_of(_, F), \+ upward(F), \+ memberchk(F, [_]) ),
                                      ( face_of(_, F), \+ memberchk(F, [_]), possible(_) ),
                                      face_of(_, F) ]))) :-
    search(F, Goal, Goals),
    sources(Goals, Steps),
    assertion(Steps == Goals).
test(no_source_of_what_is_known, forall(member(Goals, [ [findall(f, G, Fs), sort(Fs, _)],
                                                        [findall(F, G, Fs), sort(Fs, [])],
                                                        [findall(F, G, _), sort(_, _)] ]))) :-
    G = ( face_of(_, F), \+ memberchk(F, [_]) ),
    sources(Goals, Steps),
    assertion(Steps == Goals).
test(scope, Scope == scope(T, [A, B], [F, Fs])) :-
    scope(T, [A, part(B), b], [source(F, [face_of(T, F)], [A, B], all([]), Fs)], Scope).
% On what it depends which faces pass Test, of a model with these parts and a variable G of the body; `all` where
% they are found again for each choice.
depends(F, upward(F), T, [_, _], _, [T]).
depends(F, adjoins(F, A), T, [A, _], _, [T, A]).
depends(F, adjoins(F, B), T, [_, B], _, [T, B]).
depends(F, square(F, A, B), _, [A, B], _, all).
depends(F, adjoins(F, A), _, [A], _, all).
depends(F, adjoins(F, G), _, [_, _], G, all).
depends(F, all([]), T, [], F, [T]).

test(found_once, forall(depends(F, Test, T, Parts, G, Expected))) :-
    gensym(once, Target),
    setup_call_cleanup(
        new_rule_module(Target),
        step_code(scope(T, Parts, [G, Fs]), context(vocabulary, Target, false),
                  source(F, [face_of(T, F)], Parts, Test, Fs), Code),
        ( forget_code(Target), '$destroy_module'(Target) )),
    (   Code = ( Listed, facetlog_sources:without(Parts0, All, Fs0) )
    ->  assertion(Parts0-Fs0 == Parts-Fs),
        Listed =.. [_|Args],
        once(append(Found, [All], Args))
    ;   Found = all
    ),
    assertion(Found == Expected).
test(names_but_for_some, Others == [a, c]) :-
    without([d, b, e], [a, b, c, d], Others).

% Rules with clauses that collect faces, and with others.
rule(( others(T, _, Fs) :- findall(F, ( face_of(T, F), possible(upward(F)) ), Found),
                           sort(Found, Fs) )).
rule(( first(T, F) :- face_of(T, F), ! )).
rule(( two(T, Fs) :- findall(F, face_of(T, F), Found), sort(Found, Fs) )).
rule(( two(_, []) :- true )).
rule(( of(t, Fs) :- findall(F, face_of(t, F), Found), sort(Found, Fs) )).
rule(( unsorted(T, Gs) :- findall(F, face_of(T, F), _), sort(_, Gs) )).

written(Goal, Goals) :-
    gensym(written, Module),
    setup_call_cleanup(
        new_rule_module(Module),
        ( forall(rule(Clause), assertz(Module:Clause)),
          written_body(Module, Goal, Goals) ),
        '$destroy_module'(Module)).

test(what_collects_stands_in_its_place, Goals =@= [findall(F, ( face_of(T, F), possible(upward(F)) ), Found),
                                                   sort(Found, Fs), separate(Fs, Gs)]) :-
    written(( others(T, _, Fs), separate(Fs, Gs) ), Goals).
test(what_else_stays, forall(member(Goal, [ first(T, _), two(T, _), of(T, _), unsorted(T, _), face_of(T, _),
                                            other:others(T, _, _) ]))) :-
    written(Goal, Goals),
    assertion(Goals == [Goal]).

:- end_tests(sources).
