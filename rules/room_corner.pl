% Made from room_corner.model by `facetlog model compile`; not to be edited by hand.
% After a change of the model run `make models`.
:- module(room_corner, []).
:- use_module(facetlog(vocabulary)).
% room_corner.model:4
model(room_corner,
      "Floor and walls from inside: two or three faces that meet square in a hollow corner.",
      [a, b]).

% room_corner.model:17  parts
candidate(room_corner, Thing, Parts) :-
    findall(Parts, likely(room_corner, Thing, Parts), Found),
    ( Found == [] -> distant(room_corner, Thing, Parts) ; member(Parts, Found) ).

% room_corner.model:17  all that may satisfy its lines
likely(room_corner, Thing, [A, B]) :-
    face_of(Thing, A),
    possible(all([measured(A), if_known(any([level(A), upright(A)])),
                  if_known(any([not(level(A)), at_most(elevation(A), 0.1*thing_height(Thing))]))])),
    shared_edge(A, B, _),
    A @< B,
    possible(all([measured(B), if_known(any([level(B), upright(B)])),
                  if_known(any([not(level(B)), at_most(elevation(B), 0.1*thing_height(Thing))]))])),
    possible(near(dihedral(A, B), 270, 15)).

% room_corner.model:17  near misses
distant(room_corner, Thing, [A2, B2]) :-
    largest_faces(Thing, Faces),
    limit(40, ( member(A, Faces), shared_edge(A, B, _) )),
    msort([A, B], [A2, B2]).
% room_corner.model:17  near misses
distant(room_corner, Thing, [A2, B2]) :-
    \+ ( face_of(Thing, A), possible(measured(A)), shared_edge(A, B, _), A @< B,
         possible(measured(B)) ),
    as_far_as_seen(Thing, [step(A, 10, measured(A)), step(B, 4, measured(B))], [A, B]),
    msort([A, B], [A2, B2]).

% room_corner.model:18  third adjoins a, third adjoins b, concave(third, a), concave(third, b)
means('room_corner.third'(Third, A, B),
      all([adjoins(Third, A), adjoins(Third, B), concave(Third, A), concave(Third, B)])).

% room_corner.model:18
members(room_corner, third, _, [A, B], Members) :-
    findall(Third,
            ( shared_edge(A, Third, _), \+ memberchk(Third, [B]),
              possible('room_corner.third'(Third, A, B)) ), Found),
    sort(Found, Members).

% room_corner.model:21  a is measured, b is measured
condition(room_corner, seen, "two of its faces were measured", _, [A, B],
          all([measured(A), measured(B)])).
% room_corner.model:22  a adjoins b
condition(room_corner, adjoining, "the faces share an edge", _, [A, B], adjoins(A, B)).
% room_corner.model:23  hollow(a, b)
condition(room_corner, hollow_corner, "the faces are hollow where they meet, at a right angle",
          _, [A, B], soft(near(dihedral(A, B), 270, 15), 0.1)).
% room_corner.model:24  each third: hollow(third, a), hollow(third, b)
condition(room_corner, third_square, "so is the third face, if there is one", Thing, [A, B],
          each(Third, Third_members,
               implies('room_corner.third'(Third, A, B),
                       all([soft(near(dihedral(Third, A), 270, 15), 0.1),
                            soft(near(dihedral(Third, B), 270, 15), 0.1)])))) :-
    members(room_corner, third, Thing, [A, B], Third_members).
% room_corner.model:26  each face other: ahead(other, a), ahead(other, b)
condition(room_corner, nothing_behind, "nothing lies behind a face but the wall itself", Thing,
          [A, B],
          each(Other, Others,
               all([soft(at_least(offset(Other, A), -(0.1*thing_length(Thing))), 0.1),
                    soft(at_least(offset(Other, B), -(0.1*thing_length(Thing))), 0.1)]))) :-
    findall(Other, ( face_of(Thing, Other), \+ memberchk(Other, [A, B]) ), Found),
    sort(Found, Others).
% room_corner.model:28  there is no face other where stands_before(other, a) or stands_before(other, b)
condition(room_corner, open, "nothing stands before the walls, turned to them or away", Thing,
          [A, B],
          not(some(Other, Others,
                   any([all([parallel(Other, A, 15),
                             soft(at_least(offset(Other, A), 0.1*thing_length(Thing)), 0.1),
                             not(any([all([adjoins(Other, A), convex(Other, A)]),
                                      all([adjoins(Other, B), convex(Other, B)])]))]),
                        all([parallel(Other, B, 15),
                             soft(at_least(offset(Other, B), 0.1*thing_length(Thing)), 0.1),
                             not(any([all([adjoins(Other, A), convex(Other, A)]),
                                      all([adjoins(Other, B), convex(Other, B)])]))])])))) :-
    findall(Other,
            ( face_of(Thing, Other), \+ memberchk(Other, [A, B]),
              possible(any([all([parallel(Other, A, 15),
                                 at_least(offset(Other, A), 0.1*thing_length(Thing)),
                                 not(any([all([adjoins(Other, A), convex(Other, A)]),
                                          all([adjoins(Other, B), convex(Other, B)])]))]),
                            all([parallel(Other, B, 15),
                                 at_least(offset(Other, B), 0.1*thing_length(Thing)),
                                 not(any([all([adjoins(Other, A), convex(Other, A)]),
                                          all([adjoins(Other, B), convex(Other, B)])]))])])) ),
            Found),
    sort(Found, Others).
% room_corner.model:30  each x of a, b: x is level or x is upright
condition(room_corner, floor, "floor and walls are level and upright", _, [A, B],
          if_known(each(X, [A, B], any([level(X), upright(X)])))).
% room_corner.model:33  each x of a, b: x is not level or elevation(x) at most 10 % of height(this)
condition(room_corner, ground, "what is level of them is the floor", Thing, [A, B],
          if_known(each(X, [A, B],
                        any([not(level(X)),
                             soft(at_most(elevation(X), 0.1*thing_height(Thing)), 0.1)])))).

written(room_corner, seen, 'room_corner.model:21', "a is measured, b is measured").
written(room_corner, adjoining, 'room_corner.model:22', "a adjoins b").
written(room_corner, hollow_corner, 'room_corner.model:23', "hollow(a, b)").
written(room_corner, third_square, 'room_corner.model:24',
        "each third: hollow(third, a), hollow(third, b)").
written(room_corner, nothing_behind, 'room_corner.model:26',
        "each face other: ahead(other, a), ahead(other, b)").
written(room_corner, open, 'room_corner.model:28',
        "there is no face other where stands_before(other, a) or stands_before(other, b)").
written(room_corner, floor, 'room_corner.model:30', "each x of a, b: x is level or x is upright").
written(room_corner, ground, 'room_corner.model:33',
        "each x of a, b: x is not level or elevation(x) at most 10 % of height(this)").

% room_corner.model:18
group(room_corner, Thing, [A, B], third, Members) :-
    members(room_corner, third, Thing, [A, B], Third_members),
    findall(Third, ( member(Third, Third_members), holds('room_corner.third'(Third, A, B)) ),
            Members).
