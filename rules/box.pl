% Made from box.model by `facetlog model compile`; not to be edited by hand.
% After a change of the model run `make models`.
:- module(box, []).
:- use_module(facetlog(vocabulary)).
% box.model:5
model(box, "A solid block with square sides, and nothing beyond them.", [a, b, c]).

% box.model:13  parts
candidate(box, Thing, Parts) :-
    findall(Parts, likely(box, Thing, Parts), Found),
    ( Found == [] -> distant(box, Thing, Parts) ; member(Parts, Found) ).

% box.model:13  all that may satisfy its lines
likely(box, Thing, [A, B, C]) :-
    face_of(Thing, A),
    possible(all([if_known(at_most(protrusion(A), 0.05*thing_length(Thing))),
                  if_known(at_least(width(A), 0.12*thing_length(Thing)))])),
    face_of(Thing, B),
    A @< B,
    possible(all([if_known(at_most(protrusion(B), 0.05*thing_length(Thing))),
                  if_known(at_least(width(B), 0.12*thing_length(Thing)))])),
    possible(if_known(near(angle(A, B), 90, 15))),
    face_of(Thing, C),
    B @< C,
    possible(all([if_known(at_most(protrusion(C), 0.05*thing_length(Thing))),
                  if_known(at_least(width(C), 0.12*thing_length(Thing)))])),
    possible(all([if_known(near(angle(A, C), 90, 15)), if_known(near(angle(B, C), 90, 15))])).

% box.model:13  near misses
distant(box, Thing, [A2, B2, C2]) :-
    as_far_as_seen(Thing,
                   [step(A, 6, all([])), step(B, 3, if_known(near(angle(A, B), 90, 15))),
                    step(C, 3,
                         all([if_known(near(angle(A, C), 90, 15)),
                              if_known(near(angle(B, C), 90, 15))]))],
                   [A, B, C]),
    msort([A, B, C], [A2, B2, C2]).

% box.model:15  there are at least 2 faces x of a, b, c where x is measured, share(x) at least 20 %, fill(x) at least 55 %, turned(x)
condition(box, sides, "two of its sides were seen, at a right angle", _, [A, B, C],
          at_least_of(2, X, X_groups,
                      all([measured(X), soft(at_least(share(X), 0.2), 0.1),
                           soft(at_least(fill(X), 0.55), 0.1),
                           some(Y, Seen, soft(near(angle(X, Y), 90, 30), 0.1))]))) :-
    exclude(==(unseen), [A, B, C], Seen),
    findall([Member], member(Member, Seen), X_groups).
% box.model:17  each pair x, y of a, b, c: angle(x, y) = 90 deg ± right
condition(box, square, "they meet at right angles", _, [A, B, C],
          if_known(each_pair(X, Y, [A, B, C], soft(near(angle(X, Y), 90, 15), 0.1)))).
% box.model:19  each x of a, b, c: protrusion(x) at most 5 % of length(this)
condition(box, flush, "nothing sticks out past them", Thing, [A, B, C],
          if_known(each(X, [A, B, C],
                        soft(at_most(protrusion(X), 0.05*thing_length(Thing)), 0.1)))).
% box.model:21  solidity(this) at least 80 %, hollow_side(this) at most 40 %
condition(box, solid, "it fills the box round it, and none of its sides is hollow", Thing,
          [_, _, _],
          all([soft(at_least(solidity(Thing), 0.8), 0.1),
               soft(at_most(hollow_side(Thing), 0.4), 0.1)])).
% box.model:23  curved(this) at most 25 %, (each face f where area(f) at least 10 % of length(this) * width(this): (there is a face p of a, b, c where parallel(f, p, right)))
condition(box, flat, "its surface is flat, and lies along its sides", Thing, [A, B, C],
          all([soft(at_most(curved(Thing), 0.25), 0.1),
               each(F, Fs,
                    implies(soft(at_least(area(F), 0.1*thing_length(Thing)*thing_width(Thing)),
                                 0.1),
                            some(P, Seen, parallel(F, P, 15))))])) :-
    findall(F,
            ( face_of(Thing, F), \+ memberchk(F, [A, B, C]),
              possible(at_least(area(F), 0.1*thing_length(Thing)*thing_width(Thing))) ),
            Found),
    sort(Found, Fs),
    exclude(==(unseen), [A, B, C], Seen).
% box.model:26  each x of a, b, c: width(x) at least 12 % of length(this)
condition(box, thick, "it is no board, door or pane", Thing, [A, B, C],
          if_known(each(X, [A, B, C], soft(at_least(width(X), 0.12*thing_length(Thing)), 0.1)))).
% box.model:28  each x of a, b, c: x is measured
condition(box, third, "three of its sides were seen", _, [A, B, C],
          expect(0.5, each(X, [A, B, C], measured(X)))).

written(box, sides, 'box.model:15',
        "there are at least 2 faces x of a, b, c where x is measured, share(x) at least 20 %, fill(x) at least 55 %, turned(x)").
written(box, square, 'box.model:17', "each pair x, y of a, b, c: angle(x, y) = 90 deg ± right").
written(box, flush, 'box.model:19',
        "each x of a, b, c: protrusion(x) at most 5 % of length(this)").
written(box, solid, 'box.model:21',
        "solidity(this) at least 80 %, hollow_side(this) at most 40 %").
written(box, flat, 'box.model:23',
        "curved(this) at most 25 %, (each face f where area(f) at least 10 % of length(this) * width(this): (there is a face p of a, b, c where parallel(f, p, right)))").
written(box, thick, 'box.model:26', "each x of a, b, c: width(x) at least 12 % of length(this)").
written(box, third, 'box.model:28', "each x of a, b, c: x is measured").

% box.model:30
size(box, _, [A, B, C], Name, Measure) :-
    longest_first([reach_behind(A), reach_behind(B), reach_behind(C)], Sorted),
    nth1(Number, Sorted, Measure),
    nth1(Number, [length, width, height], Name).
