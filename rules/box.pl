:- module(box, []).
:- use_module(library(solution_sequences)).
:- use_module(facetlog(vocabulary)).

/** <module> A box

The paper calls three planes a box if each two of them meet at 90 degrees, give or take 15. So do a
room's corner and a table. A box's faces also bound one solid: they bulge outwards where they meet,
each fills its side of the solid, and nothing sticks out past them.
*/

model(box, "A solid block: three faces that meet square at one corner, and nothing beyond them.",
      [a, b, c]).

tolerance(square,    15).     % degrees; the paper's theta
tolerance(full,      0.80).   % of the silhouette, of the rectangle: corners may be hidden or worn
tolerance(flush,     0.05).   % of the thing's length
tolerance(speck,     0.05).   % of a part's area: a smaller face contradicts nothing

% Three faces that adjoin one another. Where no three do that are square, three directions are
% looked for among all faces; a direction in which no face was measured is an unseen part: then the
% scene contradicts a box or leaves it open, but cannot prove one.
candidate(box, Thing, [A, B, C]) :-
    adjoining_three(Thing, A, B, C).
candidate(box, Thing, [A, B, C]) :-
    \+ ( adjoining_three(Thing, X, Y, Z),
         possible(each_pair(F, G, [X, Y, Z], square(F, G))) ),
    face_of(Thing, A),
    limit(20, directions(Thing, A, B, C)).    % of near misses a few are enough

adjoining_three(Thing, A, B, C) :-
    face_of(Thing, A),
    shared_edge(A, B, _), A @< B,
    shared_edge(B, C, _), B @< C,
    shared_edge(A, C, _).

directions(Thing, A, B, C) :-
    square_to_all(Thing, [A], B), A @< B,
    third_direction(Thing, A, B, C).
directions(Thing, A, unseen, unseen) :-
    \+ square_to_all(Thing, [A], _).

third_direction(Thing, A, B, C) :-
    square_to_all(Thing, [A, B], C), B @< C.
third_direction(Thing, A, B, unseen) :-
    \+ square_to_all(Thing, [A, B], _).

square_to_all(Thing, Parts, Face) :-
    face_of(Thing, Face),
    \+ memberchk(Face, Parts),
    possible(each(Part, Parts, square(Part, Face))).

means(square(X, Y), near(angle(X, Y), 90, tolerance(square))).

condition(box, seen, "three of its faces were measured", _, [A, B, C],
          each(X, [A, B, C], measured(X))).
condition(box, adjoining, "each two of the faces share an edge", _, [A, B, C],
          each_pair(X, Y, [A, B, C], adjoins(X, Y))).
condition(box, corner, "the three faces meet at one corner", _, [A, B, C],
          share_corner([A, B, C])).
condition(box, square, "the faces meet at right angles", _, [A, B, C],
          each_pair(X, Y, [A, B, C], near(angle(X, Y), 90, tolerance(square)))).
condition(box, convex, "the faces bulge outwards where they meet", _, [A, B, C],
          each_pair(X, Y, [A, B, C], convex(X, Y))).
condition(box, full, "each face fills its side of the block", _, [A, B, C],
          each(X, [A, B, C], at_least(share(X), tolerance(full)))).
condition(box, whole, "each face is a whole rectangle", _, [A, B, C],
          each(X, [A, B, C], at_least(fill(X), tolerance(full)))).
condition(box, flush, "nothing sticks out past a face", Thing, [A, B, C],
          each(X, [A, B, C], at_most(protrusion(X), tolerance(flush)*thing_length(Thing)))).
condition(box, others, "every other face lies along one of the three", Thing, [A, B, C],
          each(Other, Others, some(Part, Seen, parallel(Other, Part, tolerance(square))))) :-
    exclude(==(unseen), [A, B, C], Seen),
    findall(F,
            ( face_of(Thing, F),
              \+ memberchk(F, Seen),
              possible(some(P, Seen, at_least(area(F), tolerance(speck)*area(P)))) ),
            Found),
    sort(Found, Others).

size(box, _, [A, B, C], Name, edge_length(Edge)) :-
    shared_edge(A, B, AB),
    shared_edge(A, C, AC),
    shared_edge(B, C, BC),
    longest_first([edge_length(AB), edge_length(AC), edge_length(BC)], Edges),
    nth1(N, Edges, edge_length(Edge)),
    nth1(N, [length, width, height], Name).
