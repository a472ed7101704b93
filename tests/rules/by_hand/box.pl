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

% Who may play the parts. On things with many faces few proposals must do, and no face may be asked
% about all others:
%   - faces that adjoin one another, may be square and may fill their sides: all of these, or a box
%     could be overlooked; few faces of a thing fill its silhouette;
%   - of other three faces that adjoin, the largest: near misses;
%   - where no three adjoin that may be square: square directions, from the largest faces on. They
%     adjoin nowhere, or a direction was not seen: a near miss, or it leaves the box open.
candidate(box, Thing, [A, B, C]) :-
    full_three(Thing, A, B, C).
candidate(box, Thing, [A, B, C]) :-
    findall(Area-[X, Y, Z],
            ( adjoining_three(Thing, X, Y, Z),
              area_of_all([X, Y, Z], Area) ),
            Found),
    sort(0, @>=, Found, Largest),
    limit(20, member(_-[A, B, C], Largest)).
candidate(box, Thing, Parts) :-
    \+ ( adjoining_three(Thing, X, Y, Z),
         possible(each_pair(F, G, [X, Y, Z], square(F, G))) ),
    largest_faces(Thing, Faces),
    limit(6, member(A, Faces)),
    directions(A, Faces, Parts).

full_three(Thing, A, B, C) :-
    face_of(Thing, A),
    may_fill(A),
    shared_edge(A, B, _), A @< B, may_fill(B),
    shared_edge(B, C, _), B @< C, may_fill(C),
    shared_edge(A, C, _),
    possible(each_pair(X, Y, [A, B, C], square(X, Y))).

may_fill(Face) :-
    possible(at_least(share(Face), tolerance(full))).

adjoining_three(Thing, A, B, C) :-
    face_of(Thing, A),
    shared_edge(A, B, _), A @< B,
    shared_edge(B, C, _), B @< C,
    shared_edge(A, C, _).

area_of_all(Faces, Area) :-
    aggregate_all(sum(A), ( member(F, Faces), measure(area(F), A, _, _) ), Area).

% Of each next direction the largest faces, three at most.
directions(A, Faces, Parts) :-
    square_to_all([A], Faces, Bs),
    (   Bs == []
    ->  Parts = [A, unseen, unseen]
    ;   member(B, Bs),
        square_to_all([A, B], Faces, Cs),
        (   Cs == []
        ->  sort([A, B], [First, Second]),
            Parts = [First, Second, unseen]
        ;   member(C, Cs),
            sort([A, B, C], Parts)
        )
    ).

square_to_all(Parts, Faces, Square) :-
    findall(Face,
            limit(3, ( member(Face, Faces),
                       \+ memberchk(Face, Parts),
                       possible(each(Part, Parts, square(Part, Face))) )),
            Square).

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
    other_faces(Thing, Seen, Others).

% The faces of which an angle with the first part is known, or none contradicts; and one more, if
% there is one: that it is not known how it lies leaves the box open, and of all others the same
% would be said again.
other_faces(Thing, Seen, Others) :-
    Seen = [First|_],
    findall(Face,
            ( measure(angle(First, Face), _, _, _),
              \+ memberchk(Face, Seen),
              face_of(Thing, Face),
              counts(Face, Seen) ),
            Found),
    sort(Found, Known),
    findall(Face,
            limit(1, ( face_of(Thing, Face),
                       \+ memberchk(Face, Seen),
                       \+ measure(angle(First, Face), _, _, _),
                       counts(Face, Seen) )),
            One),
    once(append(Known, One, Others)).

% No speck beside the parts, as far as is known.
counts(Face, Seen) :-
    tolerance(speck, Share),
    (   measure(area(Face), Area, _, _),
        forall(member(Part, Seen), ( measure(area(Part), Whole, _, _), Area < Share*Whole ))
    ->  fail
    ;   true
    ).

size(box, _, [A, B, C], Name, edge_length(Edge)) :-
    shared_edge(A, B, AB),
    shared_edge(A, C, AC),
    shared_edge(B, C, BC),
    longest_first([edge_length(AB), edge_length(AC), edge_length(BC)], Edges),
    nth1(N, Edges, edge_length(Edge)),
    nth1(N, [length, width, height], Name).
