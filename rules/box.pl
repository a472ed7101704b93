% Made from box.model by `facetlog model compile`; not to be edited by hand.
% After a change of the model run `make models`.
:- module(box, []).
:- use_module(facetlog(vocabulary)).
% box.model:5
model(box,
      "A solid block: three faces that meet square at one corner, and nothing beyond them.",
      [a, b, c]).

% box.model:20  parts
candidate(box, Thing, Parts) :-
    findall(Parts, likely(box, Thing, Parts), Found),
    ( Found == [] -> distant(box, Thing, Parts) ; member(Parts, Found) ).

% box.model:20  all that may satisfy its lines
likely(box, Thing, [A, B, C]) :-
    face_of(Thing, A),
    possible(all([measured(A),
                  any([at_least(share(A), 0.8), all([whole(Thing), at_least(share(A), 0.2)])]),
                  at_most(protrusion(A), 0.05*thing_length(Thing))])),
    face_of(Thing, B),
    A @< B,
    possible(all([measured(B),
                  any([at_least(share(B), 0.8), all([whole(Thing), at_least(share(B), 0.2)])]),
                  at_most(protrusion(B), 0.05*thing_length(Thing))])),
    possible(near(angle(A, B), 90, 15)),
    face_of(Thing, C),
    B @< C,
    possible(all([measured(C),
                  any([at_least(share(C), 0.8), all([whole(Thing), at_least(share(C), 0.2)])]),
                  at_most(protrusion(C), 0.05*thing_length(Thing))])),
    possible(all([any([share_corner([A, B, C]), whole(Thing)]), near(angle(A, C), 90, 15),
                  near(angle(B, C), 90, 15)])).

% box.model:20  near misses
distant(box, Thing, [A2, B2, C2]) :-
    as_far_as_seen(Thing,
                   [step(A, 6, measured(A)),
                    step(B, 3, all([measured(B), near(angle(A, B), 90, 15)])),
                    step(C, 3,
                         all([measured(C), near(angle(A, C), 90, 15), near(angle(B, C), 90, 15)]))],
                   [A, B, C]),
    msort([A, B, C], [A2, B2, C2]).

% box.model:22  each x of a, b, c: x is measured
condition(box, seen, "three of its faces were measured", _, [A, B, C],
          each(X, [A, B, C], measured(X))).
% box.model:23  this is not whole or solidity(this) at least solid
condition(box, solid, "it fills the box round it", Thing, [_, _, _],
          any([not(whole(Thing)), at_least(solidity(Thing), 0.85)])).
% box.model:24  (each pair x, y of a, b, c: x adjoins y) or this is whole
condition(box, adjoining, "each two of the faces share an edge", Thing, [A, B, C],
          any([each_pair(X, Y, [A, B, C], adjoins(X, Y)), whole(Thing)])).
% box.model:26  share_corner(a, b, c) or this is whole
condition(box, corner, "the three faces meet at one corner", Thing, [A, B, C],
          any([share_corner([A, B, C]), whole(Thing)])).
% box.model:27  each pair x, y of a, b, c: angle(x, y) = 90 deg ± right
condition(box, square, "the faces meet at right angles", _, [A, B, C],
          each_pair(X, Y, [A, B, C], near(angle(X, Y), 90, 15))).
% box.model:28  (each pair x, y of a, b, c: convex(x, y)) or this is whole
condition(box, convex, "the faces bulge outwards where they meet", Thing, [A, B, C],
          any([each_pair(X, Y, [A, B, C], convex(X, Y)), whole(Thing)])).
% box.model:30  each x of a, b, c: share(x) at least most or this is whole and share(x) at least 20 %
condition(box, full, "each face fills its side of the block", Thing, [A, B, C],
          each(X, [A, B, C],
               any([at_least(share(X), 0.8), all([whole(Thing), at_least(share(X), 0.2)])]))).
% box.model:32  (each x of a, b, c: fill(x) at least most) or this is whole
condition(box, whole, "each face is a whole rectangle", Thing, [A, B, C],
          any([each(X, [A, B, C], at_least(fill(X), 0.8)), whole(Thing)])).
% box.model:34  each x of a, b, c: protrusion(x) at most 5 % of length(this)
condition(box, flush, "nothing sticks out past a face", Thing, [A, B, C],
          each(X, [A, B, C], at_most(protrusion(X), 0.05*thing_length(Thing)))).
% box.model:36  this is whole and depth(this) at least 12 % of length(this) or this is not whole and (each x of a, b, c: width(x) at least 12 % of length(this))
condition(box, thick, "it is no board, door or pane", Thing, [A, B, C],
          any([all([whole(Thing), at_least(depth(Thing), 0.12*thing_length(Thing))]),
               all([not(whole(Thing)),
                    each(X, [A, B, C], at_least(width(X), 0.12*thing_length(Thing)))])])).
% box.model:40  each face other where counts(other): along(other)
condition(box, others, "every other face lies along one of the three", Thing, [A, B, C],
          each(Other, Others,
               implies(any([all([whole(Thing),
                                 at_least(area(Other),
                                          0.1*thing_length(Thing)*thing_width(Thing))]),
                            all([not(whole(Thing)),
                                 some(P, Seen, at_least(area(Other), 0.05*area(P)))])]),
                       some(P2, Seen, parallel(Other, P2, 15))))) :-
    exclude(==(unseen), [A, B, C], Seen),
    findall(Other,
            ( face_of(Thing, Other), \+ memberchk(Other, [A, B, C]),
              possible(any([all([whole(Thing),
                                 at_least(area(Other),
                                          0.1*thing_length(Thing)*thing_width(Thing))]),
                            all([not(whole(Thing)),
                                 some(P, Seen, at_least(area(Other), 0.05*area(P)))])])) ),
            Found),
    sort(Found, Others).

written(box, seen, 'box.model:22', "each x of a, b, c: x is measured").
written(box, solid, 'box.model:23', "this is not whole or solidity(this) at least solid").
written(box, adjoining, 'box.model:24',
        "(each pair x, y of a, b, c: x adjoins y) or this is whole").
written(box, corner, 'box.model:26', "share_corner(a, b, c) or this is whole").
written(box, square, 'box.model:27', "each pair x, y of a, b, c: angle(x, y) = 90 deg ± right").
written(box, convex, 'box.model:28',
        "(each pair x, y of a, b, c: convex(x, y)) or this is whole").
written(box, full, 'box.model:30',
        "each x of a, b, c: share(x) at least most or this is whole and share(x) at least 20 %").
written(box, whole, 'box.model:32',
        "(each x of a, b, c: fill(x) at least most) or this is whole").
written(box, flush, 'box.model:34',
        "each x of a, b, c: protrusion(x) at most 5 % of length(this)").
written(box, thick, 'box.model:36',
        "this is whole and depth(this) at least 12 % of length(this) or this is not whole and (each x of a, b, c: width(x) at least 12 % of length(this))").
written(box, others, 'box.model:40', "each face other where counts(other): along(other)").

% box.model:42
size(box, _, [A, B, C], Name, Measure) :-
    longest_first([shared_length(A, B), shared_length(A, C), shared_length(B, C)], Sorted),
    nth1(Number, Sorted, Measure),
    nth1(Number, [length, width, height], Name).
