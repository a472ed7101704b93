% Made from box.model by `facetlog model compile`; not to be edited by hand.
% After a change of the model run `make models`.
:- module(box, []).
:- use_module(facetlog(vocabulary)).
% box.model:5
model(box,
      "A solid block: three faces that meet square at one corner, and nothing beyond them.",
      [a, b, c]).

% box.model:34  parts
candidate(box, Thing, Parts) :-
    findall(Parts, likely(box, Thing, Parts), Found),
    ( Found == [] -> distant(box, Thing, Parts) ; member(Parts, Found) ).

% box.model:34  all that may satisfy its lines
likely(box, Thing, [A, B, C]) :-
    face_of(Thing, A),
    possible(if_known(at_most(protrusion(A), 0.05*thing_length(Thing)))),
    face_of(Thing, B),
    A @< B,
    possible(if_known(at_most(protrusion(B), 0.05*thing_length(Thing)))),
    possible(if_known(near(angle(A, B), 90, 15))),
    face_of(Thing, C),
    B @< C,
    possible(if_known(at_most(protrusion(C), 0.05*thing_length(Thing)))),
    possible(all([any([share_corner([A, B, C]), whole(Thing), scanned(Thing)]),
                  if_known(near(angle(A, C), 90, 15)), if_known(near(angle(B, C), 90, 15))])).

% box.model:34  near misses
distant(box, Thing, [A2, B2, C2]) :-
    as_far_as_seen(Thing,
                   [step(A, 6, all([])), step(B, 3, if_known(near(angle(A, B), 90, 15))),
                    step(C, 3,
                         all([if_known(near(angle(A, C), 90, 15)),
                              if_known(near(angle(B, C), 90, 15))]))],
                   [A, B, C]),
    msort([A, B, C], [A2, B2, C2]).

% box.model:36  (each x of a, b, c: x is measured) or this is scanned
condition(box, seen, "three of its faces were measured", Thing, [A, B, C],
          any([each(X, [A, B, C], measured(X)), scanned(Thing)])).
% box.model:37  this is not whole or solidity(this) at least solid and hollow_side(this) at most 30 %
condition(box, solid, "it fills the box round it, and none of its sides is hollow", Thing,
          [_, _, _],
          any([not(whole(Thing)),
               all([soft(at_least(solidity(Thing), 0.85), 0.1),
                    soft(at_most(hollow_side(Thing), 0.3), 0.1)])])).
% box.model:40  (each pair x, y of a, b, c: x adjoins y) or this is whole or this is scanned
condition(box, adjoining, "each two of the faces share an edge", Thing, [A, B, C],
          any([each_pair(X, Y, [A, B, C], adjoins(X, Y)), whole(Thing), scanned(Thing)])).
% box.model:42  share_corner(a, b, c) or this is whole or this is scanned
condition(box, corner, "the three faces meet at one corner", Thing, [A, B, C],
          any([share_corner([A, B, C]), whole(Thing), scanned(Thing)])).
% box.model:44  each pair x, y of a, b, c: angle(x, y) = 90 deg ± right
condition(box, square, "the faces meet at right angles", _, [A, B, C],
          if_known(each_pair(X, Y, [A, B, C], soft(near(angle(X, Y), 90, 15), 0.1)))).
% box.model:46  (each pair x, y of a, b, c: angle(x, y) / 90 deg = 100 % ± 33 %) or this is scanned
condition(box, sure, "their angles are known", Thing, [A, B, C],
          any([each_pair(X, Y, [A, B, C], soft(near(angle(X, Y)/90, 1, 0.33), 0.1)),
               scanned(Thing)])).
% box.model:48  (each pair x, y of a, b, c: convex(x, y)) or this is whole or this is scanned
condition(box, convex, "the faces bulge outwards where they meet", Thing, [A, B, C],
          any([each_pair(X, Y, [A, B, C], convex(X, Y)), whole(Thing), scanned(Thing)])).
% box.model:50  (each x of a, b, c: share(x) at least most or this is whole and share(x) at least 20 %) or this is scanned
condition(box, full, "each face fills its side of the block", Thing, [A, B, C],
          any([each(X, [A, B, C],
                    any([soft(at_least(share(X), 0.8), 0.1),
                         all([whole(Thing), soft(at_least(share(X), 0.2), 0.1)])])),
               scanned(Thing)])).
% box.model:52  (each x of a, b, c: fill(x) at least most) or this is whole or this is scanned
condition(box, whole, "each face is a whole rectangle", Thing, [A, B, C],
          any([each(X, [A, B, C], soft(at_least(fill(X), 0.8), 0.1)), whole(Thing),
               scanned(Thing)])).
% box.model:54  each x of a, b, c: protrusion(x) at most 5 % of length(this)
condition(box, flush, "nothing sticks out past a face", Thing, [A, B, C],
          if_known(each(X, [A, B, C],
                        soft(at_most(protrusion(X), 0.05*thing_length(Thing)), 0.1)))).
% box.model:56  this is whole and depth(this) at least 12 % of length(this) or this is scanned and depth(this) at least 12 % of length(this) or this is not whole and this is not scanned and (each x of a, b, c: width(x) at least 12 % of length(this))
condition(box, thick, "it is no board, door or pane", Thing, [A, B, C],
          any([all([whole(Thing), soft(at_least(depth(Thing), 0.12*thing_length(Thing)), 0.1)]),
               all([scanned(Thing), soft(at_least(depth(Thing), 0.12*thing_length(Thing)), 0.1)]),
               all([not(whole(Thing)), not(scanned(Thing)),
                    each(X, [A, B, C], soft(at_least(width(X), 0.12*thing_length(Thing)), 0.1))])])).
% box.model:61  each face other where counts(other): along(other)
condition(box, others, "every other face lies along one of the three", Thing, [A, B, C],
          each(Other, Others,
               implies(any([all([scanned(Thing),
                                 soft(at_least(area(Other),
                                               0.05*thing_length(Thing)*thing_width(Thing)),
                                      0.1)]),
                            all([not(whole(Thing)), not(scanned(Thing)),
                                 some(P, Seen, soft(at_least(area(Other), 0.05*area(P)), 0.1))])]),
                       some(P2, Seen, parallel(Other, P2, 15))))) :-
    exclude(==(unseen), [A, B, C], Seen),
    findall(Other,
            ( face_of(Thing, Other), \+ memberchk(Other, [A, B, C]),
              possible(any([all([scanned(Thing),
                                 at_least(area(Other),
                                          0.05*thing_length(Thing)*thing_width(Thing))]),
                            all([not(whole(Thing)), not(scanned(Thing)),
                                 some(P, Seen, at_least(area(Other), 0.05*area(P)))])])) ),
            Found),
    sort(Found, Others).
% box.model:63  this is not scanned or (there is a face x of a, b, c where clear(x), (there is a face y of a, b, c where plain(y), x adjoins y, convex(x, y)))
condition(box, two_sides, "two of its sides were scanned and bulge outwards where they meet",
          Thing, [A, B, C],
          any([not(scanned(Thing)),
               some(X, Seen,
                    all([soft(at_least(share(X), 0.55), 0.1), soft(at_least(fill(X), 0.8), 0.1),
                         some(Y, Seen,
                              all([soft(at_least(share(Y), 0.4), 0.1),
                                   soft(at_least(fill(Y), 0.55), 0.1), adjoins(X, Y),
                                   convex(X, Y)]))]))])) :-
    exclude(==(unseen), [A, B, C], Seen).
% box.model:67  this is not scanned or (there is no face f where area(f) at least 1 % of length(this) * width(this), behind(f) or thin(f))
condition(box, closed, "no surface was seen behind its sides", Thing, [A, B, C],
          any([not(scanned(Thing)),
               not(some(F, Fs,
                        all([soft(at_least(area(F), 0.01*thing_length(Thing)*thing_width(Thing)),
                                  0.1),
                             any([some(P, Seen,
                                       all([soft(at_most(angle(F, P), 15), 0.1),
                                            soft(at_most(offset(F, P),
                                                         -(0.08*thing_length(Thing))),
                                                 0.1)])),
                                  some(P2, Seen,
                                       all([soft(at_least(angle(F, P2), 165), 0.1),
                                            soft(at_least(offset(F, P2),
                                                          -(0.12*thing_length(Thing))),
                                                 0.1)]))])])))])) :-
    exclude(==(unseen), [A, B, C], Seen),
    findall(F,
            ( face_of(Thing, F), \+ memberchk(F, [A, B, C]),
              possible(all([at_least(area(F), 0.01*thing_length(Thing)*thing_width(Thing)),
                            any([some(P, Seen,
                                      all([at_most(angle(F, P), 15),
                                           at_most(offset(F, P), -(0.08*thing_length(Thing)))])),
                                 some(P2, Seen,
                                      all([at_least(angle(F, P2), 165),
                                           at_least(offset(F, P2), -(0.12*thing_length(Thing)))]))])])) ),
            Found),
    sort(Found, Fs).
% box.model:70  this is not scanned or curved(this) at most bent
condition(box, flat, "its surface is flat", Thing, [_, _, _],
          any([not(scanned(Thing)), soft(at_most(curved(Thing), 0.15), 0.1)])).
% box.model:71  this is not scanned or (each x of a, b, c: x is measured)
condition(box, third, "three of its sides were seen", Thing, [A, B, C],
          expect(0.5, any([not(scanned(Thing)), each(X, [A, B, C], measured(X))]))).

written(box, seen, 'box.model:36', "(each x of a, b, c: x is measured) or this is scanned").
written(box, solid, 'box.model:37',
        "this is not whole or solidity(this) at least solid and hollow_side(this) at most 30 %").
written(box, adjoining, 'box.model:40',
        "(each pair x, y of a, b, c: x adjoins y) or this is whole or this is scanned").
written(box, corner, 'box.model:42', "share_corner(a, b, c) or this is whole or this is scanned").
written(box, square, 'box.model:44', "each pair x, y of a, b, c: angle(x, y) = 90 deg ± right").
written(box, sure, 'box.model:46',
        "(each pair x, y of a, b, c: angle(x, y) / 90 deg = 100 % ± 33 %) or this is scanned").
written(box, convex, 'box.model:48',
        "(each pair x, y of a, b, c: convex(x, y)) or this is whole or this is scanned").
written(box, full, 'box.model:50',
        "(each x of a, b, c: share(x) at least most or this is whole and share(x) at least 20 %) or this is scanned").
written(box, whole, 'box.model:52',
        "(each x of a, b, c: fill(x) at least most) or this is whole or this is scanned").
written(box, flush, 'box.model:54',
        "each x of a, b, c: protrusion(x) at most 5 % of length(this)").
written(box, thick, 'box.model:56',
        "this is whole and depth(this) at least 12 % of length(this) or this is scanned and depth(this) at least 12 % of length(this) or this is not whole and this is not scanned and (each x of a, b, c: width(x) at least 12 % of length(this))").
written(box, others, 'box.model:61', "each face other where counts(other): along(other)").
written(box, two_sides, 'box.model:63',
        "this is not scanned or (there is a face x of a, b, c where clear(x), (there is a face y of a, b, c where plain(y), x adjoins y, convex(x, y)))").
written(box, closed, 'box.model:67',
        "this is not scanned or (there is no face f where area(f) at least 1 % of length(this) * width(this), behind(f) or thin(f))").
written(box, flat, 'box.model:70', "this is not scanned or curved(this) at most bent").
written(box, third, 'box.model:71', "this is not scanned or (each x of a, b, c: x is measured)").

% box.model:74
size(box, _, [A, B, C], Name, Measure) :-
    longest_first([shared_length(A, B), shared_length(A, C), shared_length(B, C)], Sorted),
    nth1(Number, Sorted, Measure),
    nth1(Number, [length, width, height], Name).
