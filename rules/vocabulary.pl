:- module(vocabulary, [ thing/1,              % ?Thing
                        face_of/2,            % +Thing, -Face
                        loose_edge_of/2,      % +Thing, -Edge
                        shared_edge/3,        % ?Face, ?Face, -Edge
                        standing_below/2,     % +Face, -FaceOrEdge
                        undersides/2,         % +Face, -Faces
                        largest_faces/2,      % +Thing, -Faces
                        longest_first/2,      % +Measures, -Measures
                        holds/1,              % :Test
                        possible/1,           % :Test
                        each_pair/4,          % -X, -Y, ?Faces, :Test
                        measure/4,            % +Measure, -Value, -Sd, -Kind
                        relation/2,           % +Relation, -Truth
                        missing_because/2,    % +MeasureOrRelation, -Cause
                        known_measure/1,      % ?Measure
                        known_relation/1,     % ?Relation
                        derived_word/1        % ?Word
                      ]).

/** <module> The geometry vocabulary

What rules are written in. There are three sorts of words:

  - *relations* (adjoins, convex, upward, ...), true, false or unknown of given faces;
  - *measures* (angle, share, elevation, ...), a value with its standard deviation, or unknown;
  - *searches* (face_of/2, standing_below/2, ...), Prolog predicates that propose faces.

Relations and measures appear as terms in the tests of a model, so that every verdict can say what
it compared with what; docs/models.md lists them. Unknown has causes that a reader can remove: up or
scale not given, or a face not seen. A part that was not seen is written `unseen`; whatever is asked
of it is unknown. Only measured faces are evidence: a face that was completed from its neighbours
is never proposed.
*/

:- use_module(library(lists)).
:- use_module(library(aggregate)).
:- use_module(library(apply)).
:- use_module(library(pairs)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog_kb(evaluate)).
:- use_module(facetlog_kb(recall)).
:- use_module(facetlog(grouping)).
:- reexport(facetlog(grouping), [separate/2]).
:- use_module(facetlog_kb(pairs)).

:- meta_predicate holds(:), possible(:), each_pair(?, ?, ?, :).

%!  tolerance(?Name, ?Value) is nondet.
%
%   How exact a word is meant, degrees or ratios. `level` and `upright` are the language's
%   definitions; `reaches` and `apart` allow for ends that pictures show badly.

tolerance(level,   10).     % degrees from horizontal
tolerance(upright, 10).     % degrees from vertical
tolerance(reaches, 0.15).   % of a height: how short of an end still counts as there
tolerance(board,   0.20).   % of a height: how thick a board on legs may be

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
    (   face_of(Thing, Support)
    ;   loose_edge_of(Thing, Support)
    ),
    Support \== Face,
    tolerance(reaches, Share),
    holds(upright(Support)),
    holds(at_most(bottom_of(Support), Share*elevation(Face))),
    holds(at_most(top_of(Support), (1 + Share)*elevation(Face))),
    holds(at_least(top_of(Support), 0.5*elevation(Face))).

%!  undersides(+Face, -Faces) is det.
%
%   Faces are Face and, if they were measured, the lower sides of the board whose upper side it is:
%   space beneath a board begins at its lower side.

undersides(Face, [Face|Lower]) :-
    tolerance(board, Share),
    findall(Other,
            ( fact(opposite(Face, Other)),
              fact(evidence(Other, measured)),
              holds(at_most(elevation(Other), elevation(Face))),
              holds(at_least(elevation(Other), (1 - Share)*elevation(Face))) ),
            Found),
    sort(Found, Lower).

%!  longest_first(+Measures, -Sorted) is semidet.
%
%   The same measures, the greatest value first; fails if one of them is unknown.

longest_first(Measures, Sorted) :-
    maplist(value_of, Measures, Values),
    pairs_keys_values(Pairs, Values, Measures),
    sort(1, @>=, Pairs, Descending),
    pairs_values(Descending, Sorted).

value_of(Measure, Value) :-
    measure(Measure, Value, _, _).

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

                 /*******************************
                 *           MEASURES           *
                 *******************************/

%!  measure(+Measure, -Value, -Sd, -Kind) is semidet.
%
%   Value and standard deviation of Measure. Kind is deg, ratio, count, length or area. Fails if
%   the scene does not know.

measure(angle(A, B), V, Sd, deg)        :- fact(angle(A, B, V, Sd)).
measure(dihedral(A, B), V, Sd, deg)     :- fact(dihedral(A, B, V, Sd)).
measure(tilt(F), V, Sd, deg)            :- fact(tilt(F, V, Sd)).
measure(tilt(E), V, 0, deg)             :- edge_tilt(E, V).
measure(area(F), V, Sd, area)           :- fact(area(F, V, Sd)).
measure(length(F), V, Sd, length)       :- fact(length(F, V, Sd)).
measure(width(F), V, Sd, length)        :- fact(width(F, V, Sd)).
measure(edge_length(E), V, Sd, length)  :- fact(edge_length(E, V, Sd)).
measure(fill(F), V, Sd, ratio)          :- fact(fill(F, V, Sd)).
measure(coverage(F), V, 0, ratio)       :- fact(coverage(F, V)).
measure(share(F), V, Sd, ratio)         :- fact(share(F, V, Sd)).
measure(protrusion(F), V, Sd, length)   :- fact(protrusion(F, V, Sd)).
measure(offset(A, B), V, Sd, length)    :- fact(offset(A, B, V, Sd)).
measure(elevation(F), V, Sd, length)    :- fact(elevation(F, V, Sd)).
measure(top_of(X), V, Sd, length)       :- fact(top_of(X, V, Sd)).
measure(bottom_of(X), V, Sd, length)    :- fact(bottom_of(X, V, Sd)).
measure(clear_below(F), V, 0, length)   :- fact(clear_below(F, V)).
measure(overlap(A, B), V, 0, ratio)     :- fact(overlap(A, B, V)).
measure(gap(A, B), V, Sd, length)       :- fact(gap(A, B, V, Sd)).
measure(thing_length(T), V, 0, length)  :- fact(thing_size(T, V, _, _)).
measure(thing_width(T), V, 0, length)   :- fact(thing_size(T, _, V, _)).
measure(thing_height(T), V, Sd, length) :-
    recall(vocabulary, thing_height, T, measure, max(V, Sd), highest_part(T, max(V, Sd))).
measure(metres(V), V, 0, length)        :- number(V), fact(scale(metric)).
measure(count(List), V, 0, count)       :- is_list(List), length(List, V).

%   Asked of every candidate, and it goes through the whole thing: remembered.
highest_part(Thing, Highest) :-
    aggregate_all(max(H, S), ( fact(part_of(X, Thing)), fact(top_of(X, H, S)) ), Highest).

edge_tilt(Edge, Degrees) :-
    fact(edge(Edge, V1, V2)),
    fact(up(X, Y, Z)),
    fact(point(V1, X1, Y1, Z1)),
    fact(point(V2, X2, Y2, Z2)),
    distance([X1, Y1, Z1], [X2, Y2, Z2], Length),
    Length > 0,
    DX is X2-X1,
    DY is Y2-Y1,
    DZ is Z2-Z1,
    dot([DX, DY, DZ], [X, Y, Z], Rise),
    % The tilt of an edge is that of its own direction: 0 lying, 90 standing.
    Degrees is asin(min(1.0, abs(Rise)/Length))*180/pi.

                 /*******************************
                 *           RELATIONS          *
                 *******************************/

%!  relation(+Relation, -Truth) is semidet.
%
%   Truth is true, false or unknown. Fails if Relation is not a word of the vocabulary.

relation(Relation, Truth) :-
    known_relation(Relation),
    (   arg(_, Relation, Part),
        mentions_unseen(Part)
    ->  Truth = unknown
    ;   truth(Relation, Truth0)
    ->  Truth = Truth0
    ).

%!  known_measure(?Measure) is nondet.
%!  known_relation(?Relation) is nondet.
%!  derived_word(?Word) is nondet.
%
%   The words of the vocabulary, as terms with fresh arguments.

known_measure(Measure) :-
    clause(measure(Measure, _, _, _), _).

derived_word(Word) :-
    clause(means(Word, _), _).

known_relation(measured(_)).
known_relation(adjoins(_, _)).
known_relation(coplanar(_, _)).
known_relation(opposite(_, _)).
known_relation(convex(_, _)).
known_relation(concave(_, _)).
known_relation(upward(_)).
known_relation(downward(_)).
known_relation(share_corner(_)).

%!  missing_because(+MeasureOrRelation, -Cause) is det.
%
%   Why the scene does not know it: unseen (a part was not seen), up or scale (not given), or
%   unstated (no such fact was found).

missing_because(Word, Cause) :-
    (   arg(_, Word, Part),
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
needs_up(elevation(_)).
needs_up(top_of(_)).
needs_up(bottom_of(_)).
needs_up(clear_below(_)).
needs_up(overlap(_, _)).
needs_up(thing_height(_)).
needs_up(upward(_)).
needs_up(downward(_)).

mentions_unseen(Part) :-
    var(Part),
    !,
    fail.
mentions_unseen(unseen).
mentions_unseen([Part|Parts]) :-
    memberchk(unseen, [Part|Parts]).

truth(measured(F), Truth)     :- settled(fact(evidence(F, measured)), Truth).
truth(adjoins(A, B), Truth)   :- settled(fact(adjoins(A, B, _)), Truth).
truth(coplanar(A, B), Truth)  :- settled(fact(coplanar(A, B)), Truth).
truth(opposite(A, B), Truth)  :- settled(fact(opposite(A, B)), Truth).
truth(convex(A, B), Truth)    :- either(fact(convex(A, B)), fact(concave(A, B)), Truth).
truth(concave(A, B), Truth)   :- either(fact(concave(A, B)), fact(convex(A, B)), Truth).
% The tilt of a face is known exactly where up is.
truth(upward(F), Truth)       :- either(fact(upward(F)), fact(tilt(F, _, _)), Truth).
truth(downward(F), Truth)     :- either(fact(downward(F)), fact(tilt(F, _, _)), Truth).
truth(share_corner([]), true).
truth(share_corner([First|Faces]), Truth) :-
    settled(( fact(corner(First, _, V)),
              forall(member(F, Faces), fact(corner(F, _, V))) ), Truth).

settled(Goal, Truth) :-
    ( call(Goal) -> Truth = true ; Truth = false ).

either(For, Against, Truth) :-
    (   call(For)
    ->  Truth = true
    ;   call(Against)
    ->  Truth = false
    ;   Truth = unknown
    ).

                 /*******************************
                 *         DERIVED WORDS        *
                 *******************************/

%!  means(?Word, -Test) is semidet.
%
%   Word is short for Test.

means(level(X),   at_most(tilt(X), Limit))  :- tolerance(level, Limit).
means(upright(X), at_least(tilt(X), Limit)) :- tolerance(upright, Slack), Limit is 90 - Slack.
means(parallel(A, B, Tol), any([at_most(angle(A, B), Tol), at_least(angle(A, B), 180 - Tol)])).
means(closes(Side, Face),
      all([ adjoins(Side, Face),
            upright(Side),
            at_most(bottom_of(Side), 0.5*elevation(Face)),
            at_least(fill(Side), 0.5),
            at_least(share(Side), 0.5) ])).
