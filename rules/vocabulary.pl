:- module(vocabulary, [ thing/1,              % ?Thing
                        face_of/2,            % +Thing, -Face
                        element_of/2,         % +Thing, -FaceOrEdge
                        loose_edge_of/2,      % +Thing, -Edge
                        edge_of/2,            % ?Thing, -Edge
                        vertex_of/2,          % ?Thing, -Vertex
                        shared_edge/3,        % ?Face, ?Face, -Edge
                        standing_below/2,     % +Face, -FaceOrEdge
                        piece_in/2,           % ?Thing, -Piece
                        largest_pieces/2,     % +Thing, -Pieces
                        opening_through/2,    % ?Thing, -Opening
                        largest_openings/2,   % +Thing, -Openings
                        hollow_in/2,          % ?Thing, -Hollow
                        largest_hollows/2,    % +Thing, -Hollows
                        nearest_pieces/4,     % +Thing, +Pieces, +Fitting, -Nearest
                        piece_choice/4,       % +Pieces, +Count, +Others, -Piece
                        undersides/2,         % +Face, -Faces
                        largest_faces/2,      % +Thing, -Faces
                        longest_first/2,      % :Measures, -Measures
                        holds/1,              % :Test
                        possible/1,           % :Test
                        as_far_as_seen/3,     % +Thing, :Steps, -Parts
                        each_pair/4,          % -X, -Y, ?Faces, :Test
                        relation/2,           % +Relation, -Truth
                        rests_on/2,           % ?Relation, -Test
                        missing_because/2,    % +MeasureOrRelation, -Cause
                        known_relation/1,     % ?Relation
                        derived_word/1        % ?Word
                      ]).

/** <module> The geometry vocabulary

What rules are written in. There are three sorts of words:

  - *relations* (adjoins, convex, upward, ...), true, false or unknown of given faces;
  - *measures* (angle, share, elevation, ...), a value with its standard deviation, or unknown;
  - *searches* (face_of/2, standing_below/2, ...), Prolog predicates that propose faces.

Relations and measures appear as terms in the tests of a model, so that every verdict can say what
it compared with what; `facetlog model words` lists them. Unknown has causes that a reader can remove: up or
scale not given, or a face not seen. A part that was not seen is written `unseen`; whatever is asked
of it is unknown. Only measured faces are evidence: a face that was completed from its neighbours
is never proposed.

Pieces, the solid parts of a thing, are worked out only for models that name them. What is asked of
pieces therefore has words of its own: piece_length, piece_level, ... where models say `length(x)` or
`x is level`. So have openings.
*/

:- use_module(library(apply)).
:- use_module(library(lists)).
:- use_module(library(pairs)).
:- use_module(library(solution_sequences)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog_kb(say)).
:- reexport(facetlog(grouping), [separate/2]).
:- reexport(facetlog(measures), [measure/4, known_measure/1]).
:- use_module(facetlog(measures), [measure_of_space/1]).
:- reexport(facetlog(line_labels), [line_label/3, impossible_drawing/2]).
:- use_module(facetlog_kb(pairs)).
:- use_module(facetlog_kb(seen_parts)).
:- use_module(facetlog_kb(quantities)).
:- reexport(facetlog_kb(model_test), [part_in/4]).

:- meta_predicate holds(:), possible(:), each_pair(?, ?, ?, :), as_far_as_seen(+, :, -),
                  longest_first(:, -).

%!  tolerance(?Name, ?Value) is nondet.
%
%   How exact a word is meant, degrees or ratios. `level` and `upright` are the language's
%   definitions; `reaches` and `apart` allow for ends that pictures show badly.

tolerance(level,   10).     % degrees from horizontal
tolerance(upright, 10).     % degrees from vertical
tolerance(reaches, 0.15).   % of a height: how short of an end still counts as there
tolerance(board,   0.20).   % of a height: how thick a board on legs may be
tolerance(alike,   0.05).   % of a size: congruent faces may differ by so much
tolerance(thin,    0.35).   % of a piece's width: a board is no thicker
tolerance(explained, 0.99). % of a thing's volume: so much pieces fill that are all it has
tolerance(slender, 0.35).   % of a piece's length: a bar is no wider
tolerance(shape,   0.10).   % of these two: over so much to either side a shape is in doubt
tolerance(touch,   3).      % deviations: a gap of so few is none, as perception takes it for contacts

                 /*******************************
                 *           SEARCHES           *
                 *******************************/

%!  thing(?Thing) is nondet.

thing(Thing) :-
    fact(thing(Thing)).

%!  face_of(?Thing, ?Face) is nondet.
%
%   Face is a measured face of Thing.

face_of(Thing, Face) :-
    fact(part_of(Face, Thing)),
    fact(face(Face)),
    fact(evidence(Face, measured)).

%!  largest_faces(+Thing, -Faces) is det.
%
%   The measured faces of Thing, the largest first.

largest_faces(Thing, Faces) :-
    findall(Area-Face, ( face_of(Thing, Face), fact(area(Face, Area, _)) ), Found),
    sort(0, @>=, Found, Sorted),
    pairs_values(Sorted, Faces).

%!  loose_edge_of(?Thing, ?Edge) is nondet.
%
%   Edge is a measured edge of Thing that bounds no face.

loose_edge_of(Thing, Edge) :-
    fact(part_of(Edge, Thing)),
    fact(edge(Edge, _, _)),
    \+ fact(bounds(Edge, _)),
    fact(evidence(Edge, measured)).

%!  element_of(?Thing, ?FaceOrEdge) is nondet.
%
%   What was measured of Thing: its faces and its loose edges.

element_of(Thing, Face) :-
    face_of(Thing, Face).
element_of(Thing, Edge) :-
    loose_edge_of(Thing, Edge).

%!  edge_of(?Thing, ?Edge) is nondet.
%
%   Edge is a side of a measured face of Thing, or a loose edge; each once.

edge_of(Thing, Edge) :-
    distinct(Thing-Edge, ( loose_edge_of(Thing, Edge)
                         ; face_of(Thing, Face),
                           fact(bounds(Edge, Face)) )).

%!  vertex_of(?Thing, ?Vertex) is nondet.
%
%   Vertex is a corner of a measured face of Thing; each once.

vertex_of(Thing, Vertex) :-
    distinct(Thing-Vertex, ( face_of(Thing, Face),
                             fact(corner(Face, _, Vertex)) )).

%!  piece_in(?Thing, -Piece) is nondet.
%
%   Piece is a solid part of Thing.

piece_in(Thing, Piece) :-
    fact(piece_of(Piece, Thing)).

%!  largest_pieces(+Thing, -Pieces) is det.
%
%   The pieces of Thing, that with the largest box first.

largest_pieces(Thing, Pieces) :-
    findall(Volume-Piece,
            ( piece_in(Thing, Piece),
              fact(piece_size(Piece, Length, Width, Thickness, _)),
              Volume is Length*Width*Thickness ),
            Found),
    sort(0, @>=, Found, Sorted),
    pairs_values(Sorted, Pieces).

%!  opening_through(?Thing, -Opening) is nondet.
%
%   One sees through Thing at Opening.

opening_through(Thing, Opening) :-
    fact(opening_of(Opening, Thing)).

%!  largest_openings(+Thing, -Openings) is det.
%
%   The openings of Thing, that with the largest rectangle first.

largest_openings(Thing, Openings) :-
    findall(Opening, opening_through(Thing, Opening), Found),
    largest_holes(Found, Openings).

%!  hollow_in(?Thing, -Hollow) is nondet.
%
%   Hollow is a space within Thing that is open at one side.

hollow_in(Thing, Hollow) :-
    fact(hollow_of(Hollow, Thing)).

%!  largest_hollows(+Thing, -Hollows) is det.
%
%   The hollows of Thing, that with the largest section first.

largest_hollows(Thing, Hollows) :-
    findall(Hollow, hollow_in(Thing, Hollow), Found),
    largest_holes(Found, Hollows).

largest_holes(Holes, Largest) :-
    findall(Area-Hole,
            ( member(Hole, Holes),
              fact(opening_size(Hole, Length, Width, _)),
              Area is Length*Width ),
            Found),
    sort(1, @>=, Found, Sorted),
    pairs_values(Sorted, Largest).

%!  nearest_pieces(+Thing, +Pieces, +Fitting, -Nearest) is det.
%
%   Fitting lists for each test which of Pieces may pass it. Nearest are those that may pass all; where
%   all pieces of Thing are known all of them, in the order in which they pass most.

nearest_pieces(Thing, Pieces, Fitting, Nearest) :-
    findall(Misses-Piece,
            ( member(Piece, Pieces),
              exclude(memberchk(Piece), Fitting, Missed),
              length(Missed, Misses) ),
            Ranked0),
    (   holds(pieces_known(Thing))
    ->  keysort(Ranked0, Ranked),
        pairs_values(Ranked, Nearest)
    ;   findall(Piece, member(0-Piece, Ranked0), Nearest)
    ).

%!  piece_choice(+Pieces, +Count, +Others, -Piece) is nondet.
%
%   Piece is one of the first Count of Pieces (or openings) that are none of Others, or `unseen` if
%   there are none.

piece_choice(Pieces, Count, Others, Piece) :-
    subtract(Pieces, Others, Free),
    (   Free == []
    ->  Piece = unseen
    ;   limit(Count, member(Piece, Free))
    ).

%!  shared_edge(?A, ?B, -Edge) is nondet.
%
%   The measured faces A and B of one thing share Edge.

shared_edge(A, B, Edge) :-
    fact(adjoins(A, B, Edge)),
    fact(evidence(A, measured)),
    fact(evidence(B, measured)).

%!  standing_below(+Face, -Support) is nondet.
%
%   Support is an upright face or loose edge of the same thing that starts below Face and reaches
%   down to the ground.

standing_below(Face, Support) :-
    fact(part_of(Face, Thing)),
    element_of(Thing, Support),
    Support \== Face,
    holds(supports(Support, Face)).

%!  undersides(+Face, -Faces) is det.
%
%   Faces are Face and, if they were measured, the lower sides of the board whose upper side it is:
%   space beneath a board begins at its lower side.

undersides(Face, [Face|Lower]) :-
    findall(Other,
            ( fact(opposite(Face, Other)),
              holds(underside_of(Other, Face)) ),
            Found),
    sort(Found, Lower).

%!  longest_first(:Measures, -Sorted) is semidet.
%
%   The same measures, the greatest value first; fails if one of them is unknown.

longest_first(Module:Measures, Sorted) :-
    longest_first_in(Module, Measures, Sorted).

%!  holds(:Test) is semidet.
%
%   Test is known to hold in the current scene, as measured.

holds(Module:Test) :-
    state(Test, Module, holds).

%!  possible(:Test) is semidet.
%
%   Test holds or is unknown.

possible(Module:Test) :-
    state(Test, Module, State),
    State \== fails.

%!  each_pair(-X, -Y, ?Faces, :Test) is nondet.
%
%   Faces is a list of measured faces of the scene, in the order of terms, and Test holds of each two
%   of them, X and Y. Which two pass is worked out once, so this is the fast way to ask for three
%   faces at right angles: each_pair(X, Y, [A, B, C], near(angle(X, Y), 90, 15)).

each_pair(X, Y, Faces, Module:Test) :-
    each_pair_in(Module, X, Y, Faces, Test).

%!  as_far_as_seen(+Thing, :Steps, -Parts) is nondet.
%
%   Parts are faces of Thing as far as it was seen. Steps is a list of step(Variable, Count, Test): for
%   each in turn the Count largest measured faces, none twice, for which Test is possible; the earlier
%   variables are bound by then. Where there is none the variable is `unseen`. Parts are the variables.
%   No more than 60 choices are proposed.

as_far_as_seen(Thing, Module:Steps, Parts) :-
    as_far_as_seen_in(Module, Thing, Steps, Parts).

                 /*******************************
                 *           RELATIONS          *
                 *******************************/

%!  relation(+Relation, -Truth) is semidet.
%
%   Truth is true, false or unknown. Fails if Relation is not a word of the vocabulary.

relation(Relation, Truth) :-
    once(known_relation(Relation)),
    state(Relation, vocabulary, State),
    said_as(State, Truth).

said_as(holds, true).
said_as(fails, false).
said_as(unknown, unknown).

%!  known_relation(?Relation) is nondet.
%!  derived_word(?Word) is nondet.
%
%   The words of the vocabulary, as terms with fresh arguments.

derived_word(Word) :-
    clause(means(Word, _), _).

known_relation(Relation) :-
    clause(truth(Relation, _, _), _).

%!  missing_because(+MeasureOrRelation, -Cause) is det.
%
%   Why the scene does not know it: unseen (a part was not seen), up or scale (not given), or
%   unstated (no such fact was found).

missing_because(Word, Cause) :-
    (   compound(Word),
        arg(_, Word, Part),
        mentions_unseen(Part)
    ->  Cause = unseen
    ;   needs_up(Word),
        \+ fact(up(_, _, _))
    ->  Cause = up
    ;   Word = metres(_),
        \+ fact(scale(metric))
    ->  Cause = scale
    ;   Cause = unstated
    ).

needs_up(tilt(_)).
needs_up(side_tilt(_)).
needs_up(elevation(_)).
needs_up(height(_)).
needs_up(top_of(_)).
needs_up(bottom_of(_)).
needs_up(clear_below(_)).
needs_up(overlap(_, _)).
needs_up(thing_height(_)).
needs_up(on_ground(_)).
needs_up(at_rim(_, _)).
needs_up(shelves_below(_)).
needs_up(piece_beside(_, _)).
needs_up(piece_overlap(_, _)).
needs_up(inset(_, _)).
needs_up(distance(_, _)).
needs_up(smallest_spacing(_)).
needs_up(largest_spacing(_)).
needs_up(order(_)).
needs_up(corner_inset(_, _)).
needs_up(upward(_)).
needs_up(downward(_)).
needs_up(carries(_, _)).
needs_up(hangs_from(_, _)).
needs_up(Word) :-
    functor(Word, Name, 1),
    member(Of, [piece_, opening_]),
    atom_concat(Of, OfOthers, Name),
    functor(Other, OfOthers, 1),
    needs_up(Other).
needs_up(Word) :-
    compound(Word),
    compound_name_arity(Word, Name, 1),
    measure_of_space(Name),
    Name \== solidity,
    Name \== hollow_side.

mentions_unseen(Part) :-
    var(Part),
    !,
    fail.
mentions_unseen(unseen).
mentions_unseen([Part|Parts]) :-
    memberchk(unseen, [Part|Parts]).

%!  truth(?Relation, -For, -Against) is nondet.
%
%   Relation is true if the goal For succeeds, else false if Against does, else unknown.

truth(measured(F),         fact(evidence(F, measured)), seen([F])).
truth(adjoins(A, B),       fact(adjoins(A, B, _)),      seen([A, B])).
truth(coplanar(A, B),      fact(coplanar(A, B)),        seen([A, B])).
truth(opposite(A, B),      fact(opposite(A, B)),        seen([A, B])).
truth(bounds(E, F),        fact(bounds(E, F)),          seen([E, F])).
truth(touches(A, B),       no_gap(A, B),                fact(gap(A, B, _, _))).
truth(convex(A, B),        fact(convex(A, B)),          fact(concave(A, B))).
truth(concave(A, B),       fact(concave(A, B)),         fact(convex(A, B))).
% The tilt of a face is known exactly where up is.
truth(upward(F),           fact(upward(F)),             fact(tilt(F, _, _))).
truth(downward(F),         fact(downward(F)),           fact(tilt(F, _, _))).
truth(on_ground(X),        fact(on_ground(X)),          fact(bottom_of(X, _, _))).
truth(at_rim(X, F),        fact(at_rim(X, F)),          fact(tilt(F, _, _))).
truth(joins(P, Q),         fact(joins(P, Q)),           apart(P, Q)).
truth(carries(P, Q),       fact(carries(P, Q)),         heights([P, Q])).
truth(hangs_from(P, Q),    fact(hangs_from(P, Q)),      heights([P, Q])).
truth(frames(P, O),        fact(frames(P, O)),          ( pieces([P]), fact(opening(O)) )).
truth(opening_in(O, F),    fact(opening_in(O, F)),      ( fact(opening(O)), seen([F]) )).
% Of pieces and openings alike.
truth(piece_beside(X, Y),  fact(beside(X, Y, yes)),     fact(beside(X, Y, no))).
truth(piece_inside(X, Y),  fact(inside(X, Y, yes)),     fact(inside(X, Y, no))).
truth(piece_measured(P),   fact(piece_measured(P)),     pieces([P])).
truth(openings_known(T),   fact(openings_known(T)),     fail).
truth(opening_open_at_top(H),  fact(hollow_mouth(H, top, _, _, _, _)),  fact(hollow_of(H, _))).
truth(opening_open_at_side(H), fact(hollow_mouth(H, side, _, _, _, _)), fact(hollow_of(H, _))).
truth(hollows_known(T),    fact(hollows_known(T)),      fail).
truth(piece_on_ground(P),  fact(piece_on_ground(P)),    heights([P])).
truth(whole(T),            fact(whole(T)),              seen([T])).
truth(scanned(T),          fact(scanned(T)),            seen([T])).
truth(share_corner(Faces), corner_of_all(Faces),        seen(Faces)).

%!  rests_on(?Relation, -Test) is semidet.
%
%   Test is what decides Relation, to say by how much it fails: of facts that perception decides, with
%   its limits (perception/facts/pieces/solid_boxes.py).

rests_on(piece_beside(X, Y),
         all([ at_least(shared_height(X, Y), 0.5),
               at_most(sunk_share(X, Y), Sunk),
               at_most(over_share(X, Y), 0.1) ])) :-
    Sunk is 2/3.

%   No fact is about a part that was not seen.
seen(Parts) :-
    \+ ( member(Part, Parts), Part == unseen ).

pieces(Ps) :-
    forall(member(P, Ps), fact(piece(P))).

%   Of pieces between which there is volume that no piece explains nobody knows whether they touch.
apart(P, Q) :-
    pieces([P, Q]),
    \+ ( fact(may_join(P, Q)),
         fact(piece_of(P, T)),
         fact(explained(T, Share)),
         tolerance(explained, Least),
         Share < Least ).

%   What stands on what is known where up is.
heights(Ps) :-
    forall(member(P, Ps), fact(piece_heights(P, _, _, _))).

corner_of_all([]).
corner_of_all([First|Faces]) :-
    fact(corner(First, _, V)),
    forall(member(F, Faces), fact(corner(F, _, V))).

no_gap(A, B) :-
    fact(gap(A, B, Gap, Sd)),
    tolerance(touch, Sds),
    Gap =< Sds*Sd.

                 /*******************************
                 *         DERIVED WORDS        *
                 *******************************/

%!  means(?Word, -Test) is semidet.
%
%   Word is short for Test.

means(level(X),   at_most(tilt(X), Limit))  :- tolerance(level, Limit).
means(upright(X), at_least(tilt(X), Limit)) :- tolerance(upright, Slack), Limit is 90 - Slack.
means(parallel(A, B, Tol), any([at_most(angle(A, B), Tol), at_least(angle(A, B), 180 - Tol)])).
means(above(A, B), at_least(elevation(A), elevation(B))).
means(below(A, B), at_most(elevation(A), elevation(B))).
means(congruent(A, B),
      all([ near(length(A), length(B), Share*length(B)),
            near(width(A), width(B), Share*width(B)),
            near(area(A), area(B), Share*area(B)) ])) :-
    tolerance(alike, Share).
means(supports(X, Face),
      all([ upright(X),
            at_most(bottom_of(X), Share*elevation(Face)),
            any([at_most(top_of(X), Highest*elevation(Face)), at_rim(X, Face)]),
            at_least(top_of(X), 0.5*elevation(Face)) ])) :-
    tolerance(reaches, Share),
    Highest is 1 + Share.
means(underside_of(Other, Face),
      all([ opposite(Face, Other),
            measured(Other),
            at_most(elevation(Other), elevation(Face)),
            at_least(elevation(Other), Lowest*elevation(Face)) ])) :-
    tolerance(board, Share),
    Lowest is 1 - Share.
means(closes(Side, Face),
      all([ adjoins(Side, Face),
            upright(Side),
            at_most(bottom_of(Side), 0.5*elevation(Face)),
            at_least(fill(Side), 0.5),
            at_least(share(Side), 0.5) ])).
% Pieces
means(pieces_known(T), at_least(explained(T), Share)) :- tolerance(explained, Share).
means(board(P), soft(at_most(thickness(P)/piece_width(P), Share), Fade)) :-
    tolerance(thin, Share),
    tolerance(shape, Fade).
means(bar(P),
      all([ not(board(P)),
            soft(at_most(piece_width(P)/piece_length(P), Share), Fade) ])) :-
    tolerance(slender, Share),
    tolerance(shape, Fade).
means(block(P),
      all([ not(board(P)),
            soft(at_least(piece_width(P)/piece_length(P), Share), Fade) ])) :-
    tolerance(slender, Share),
    tolerance(shape, Fade).
%   A block may lie on any of its sides.
means(piece_level(P),
      any([ at_most(piece_tilt(P), Limit),
            all([ block(P), at_most(piece_side_tilt(P), Limit) ]) ])) :-
    tolerance(level, Limit).
means(piece_upright(P), at_least(piece_tilt(P), Limit)) :- tolerance(upright, Slack), Limit is 90 - Slack.
means(piece_parallel(P, Q, Tol), at_most(piece_angle(P, Q), Tol)).
%   Solids have a height: those side by side are neither above nor below one another.
means(piece_above(P, Q), at_least(piece_elevation(P), piece_top_of(Q))).
means(piece_below(P, Q), at_most(piece_elevation(P), piece_bottom_of(Q))).
% Openings
means(opening_above(P, Q), at_least(opening_elevation(P), opening_top_of(Q))).
means(opening_below(P, Q), at_most(opening_elevation(P), opening_bottom_of(Q))).
