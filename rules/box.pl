% Made from box.model by `facetlog model compile`; not to be edited by hand.
% After a change of the model run `make models`.
:- module(box, []).
:- use_module(facetlog(vocabulary)).
% box.model:5
model(box,
      "A solid block: three faces that meet square at one corner, and nothing beyond them.",
      [a, b, c]).

% box.model:15  parts
candidate(box, Thing, Parts) :-
    findall(Parts, likely(box, Thing, Parts), Found),
    ( Found == [] -> distant(box, Thing, Parts) ; member(Parts, Found) ).

% box.model:15  all that may satisfy its lines
likely(box, Thing, [A, B, C]) :-
    face_of(Thing, A),
    possible(all([measured(A), at_least(share(A), 0.8), at_least(fill(A), 0.8),
                  at_most(protrusion(A), 0.05*thing_length(Thing))])),
    shared_edge(A, B, _),
    A @< B,
    possible(all([measured(B), at_least(share(B), 0.8), at_least(fill(B), 0.8),
                  at_most(protrusion(B), 0.05*thing_length(Thing))])),
    possible(all([near(angle(A, B), 90, 15), convex(A, B)])),
    shared_edge(A, C, _),
    B @< C,
    shared_edge(B, C, _),
    possible(all([measured(C), at_least(share(C), 0.8), at_least(fill(C), 0.8),
                  at_most(protrusion(C), 0.05*thing_length(Thing))])),
    possible(all([share_corner([A, B, C]), near(angle(A, C), 90, 15), near(angle(B, C), 90, 15),
                  convex(A, C), convex(B, C)])).

% box.model:15  near misses
distant(box, Thing, [A2, B2, C2]) :-
    largest_faces(Thing, Faces),
    limit(40,
          ( member(A, Faces), shared_edge(A, B, _), shared_edge(A, C, _), B @< C,
            shared_edge(B, C, _) )),
    msort([A, B, C], [A2, B2, C2]).
% box.model:15  near misses
distant(box, Thing, [A2, B2, C2]) :-
    \+ ( face_of(Thing, A), possible(measured(A)), shared_edge(A, B, _), A @< B,
         possible(all([measured(B), near(angle(A, B), 90, 15)])), shared_edge(A, C, _), B @< C,
         shared_edge(B, C, _),
         possible(all([measured(C), near(angle(A, C), 90, 15), near(angle(B, C), 90, 15)])) ),
    as_far_as_seen(Thing,
                   [step(A, 6, measured(A)),
                    step(B, 3, all([measured(B), near(angle(A, B), 90, 15)])),
                    step(C, 3,
                         all([measured(C), near(angle(A, C), 90, 15), near(angle(B, C), 90, 15)]))],
                   [A, B, C]),
    msort([A, B, C], [A2, B2, C2]).

% box.model:17  each x of a, b, c: x is measured
condition(box, seen, "three of its faces were measured", _, [A, B, C],
          each(X, [A, B, C], measured(X))).
% box.model:18  each pair x, y of a, b, c: x adjoins y
condition(box, adjoining, "each two of the faces share an edge", _, [A, B, C],
          each_pair(X, Y, [A, B, C], adjoins(X, Y))).
% box.model:19  share_corner(a, b, c)
condition(box, corner, "the three faces meet at one corner", _, [A, B, C],
          share_corner([A, B, C])).
% box.model:20  each pair x, y of a, b, c: angle(x, y) = 90 deg ± right
condition(box, square, "the faces meet at right angles", _, [A, B, C],
          each_pair(X, Y, [A, B, C], near(angle(X, Y), 90, 15))).
% box.model:21  each pair x, y of a, b, c: convex(x, y)
condition(box, convex, "the faces bulge outwards where they meet", _, [A, B, C],
          each_pair(X, Y, [A, B, C], convex(X, Y))).
% box.model:22  each x of a, b, c: share(x) at least most
condition(box, full, "each face fills its side of the block", _, [A, B, C],
          each(X, [A, B, C], at_least(share(X), 0.8))).
% box.model:23  each x of a, b, c: fill(x) at least most
condition(box, whole, "each face is a whole rectangle", _, [A, B, C],
          each(X, [A, B, C], at_least(fill(X), 0.8))).
% box.model:24  each x of a, b, c: protrusion(x) at most 5 % of length(this)
condition(box, flush, "nothing sticks out past a face", Thing, [A, B, C],
          each(X, [A, B, C], at_most(protrusion(X), 0.05*thing_length(Thing)))).
% box.model:26  each face other where counts(other): along(other)
condition(box, others, "every other face lies along one of the three", Thing, [A, B, C],
          each(Other, Others,
               implies(some(P, Seen, at_least(area(Other), 0.05*area(P))),
                       some(P2, Seen, parallel(Other, P2, 15))))) :-
    exclude(==(unseen), [A, B, C], Seen),
    findall(Other,
            ( face_of(Thing, Other), \+ memberchk(Other, [A, B, C]),
              possible(some(P, Seen, at_least(area(Other), 0.05*area(P)))) ), Found),
    sort(Found, Others).

written(box, seen, 'box.model:17', "each x of a, b, c: x is measured").
written(box, adjoining, 'box.model:18', "each pair x, y of a, b, c: x adjoins y").
written(box, corner, 'box.model:19', "share_corner(a, b, c)").
written(box, square, 'box.model:20', "each pair x, y of a, b, c: angle(x, y) = 90 deg ± right").
written(box, convex, 'box.model:21', "each pair x, y of a, b, c: convex(x, y)").
written(box, full, 'box.model:22', "each x of a, b, c: share(x) at least most").
written(box, whole, 'box.model:23', "each x of a, b, c: fill(x) at least most").
written(box, flush, 'box.model:24',
        "each x of a, b, c: protrusion(x) at most 5 % of length(this)").
written(box, others, 'box.model:26', "each face other where counts(other): along(other)").

% box.model:28
size(box, _, [A, B, C], Name, Measure) :-
    longest_first([shared_length(A, B), shared_length(A, C), shared_length(B, C)], Sorted),
    nth1(Number, Sorted, Measure),
    nth1(Number, [length, width, height], Name).
