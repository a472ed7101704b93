:- module(line_labels, [ line_label/3,           % +View, ?Edge, ?Label
                         impossible_drawing/2,   % ?View, -Junction
                         legal/2,                % ?Type, ?Labels
                         drawing_labels/3        % +Corners, +Contour, -Found
                       ]).

/** <module> What the lines of a drawing are edges of

A line of a drawing shows an edge of a body of flat faces. It is

  - `convex` (+): both its faces are seen, and the body bulges there;
  - `concave` (-): both are seen, and the body is hollow there;
  - `occluding` (>): one of its faces is seen, and hides what lies beyond the line.

At a junction where three faces of a body meet few combinations are possible; they were found by
D. A. Huffman ("Impossible objects as nonsense sentences", Machine Intelligence 6, 1971) and
M. B. Clowes ("On seeing things", Artificial Intelligence 2, 1971). A line has one label, whichever
of its ends is asked: what no neighbour agrees with is struck out until nothing changes, and what
is left is searched (D. Waltz, "Understanding line drawings of scenes with shadows", in P. H.
Winston, ed., The Psychology of Computer Vision, 1975). A drawing without any labelling shows no
such body: it is impossible.

At a junction an occluding line is written `out` or `in`: who goes from the junction along the line,
or comes along it, has the face that hides to the right. So what one end calls `out`, the other
calls `in`.
*/

:- use_module(library(apply)).
:- use_module(library(assoc)).
:- use_module(library(lists)).
:- use_module(library(pairs)).
:- use_module(library(ugraphs)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog_kb(recall)).

                 /*******************************
                 *         THE CATALOGUE        *
                 *******************************/

%!  legal(?Type, ?Labels) is nondet.
%
%   The lines of a junction of that Type may have these Labels, counter-clockwise as one sees the
%   drawing and from the widest gap between them: an arrow's are barb, shaft, barb, a T's are bar,
%   stem, bar.

legal(l, [in,      out]).
legal(l, [out,     in]).
legal(l, [convex,  in]).
legal(l, [out,     convex]).
legal(l, [concave, out]).
legal(l, [in,      concave]).

legal(arrow, [convex,  concave, convex]).
legal(arrow, [concave, convex,  concave]).
legal(arrow, [in,      convex,  out]).

legal(fork, [convex,  convex,  convex]).
legal(fork, [concave, concave, concave]).
legal(fork, [in,      concave, out]).
legal(fork, [out,     in,      concave]).
legal(fork, [concave, out,     in]).

%   A T is where one body hides another: its bar is an edge of what is before.
legal(t, [out, convex,  in]).
legal(t, [out, concave, in]).
legal(t, [out, in,      in]).
legal(t, [out, out,     in]).

%   Two edges that run on along each other are alike; a line that ends alone may be anything.
legal(straight, [At, Other]) :- across(At, Other).
legal(end, [Label])          :- across(Label, _).

%!  across(?Label, ?Other) is nondet.
%
%   One end of a line calls Label what its other end calls Other.

across(convex,  convex).
across(concave, concave).
across(out,     in).
across(in,      out).

                 /*******************************
                 *        DRAWINGS OF VIEWS     *
                 *******************************/

%!  line_label(+View, ?Edge, ?Label) is nondet.
%
%   Every legal labelling of the drawing of View gives a line that is part of Edge that Label:
%   convex, concave or occluding. There is none where labellings differ, or where there is none.

line_label(View, Edge, Label) :-
    fact(view(View, _)),
    view_labels(View, labelled(Lines, _)),
    distinct_labels(View, Lines, Labels),
    member(Edge-Label, Labels).

distinct_labels(View, Lines, Labels) :-
    findall(Edge-Label,
            ( member(line(J, K, Label), Lines),
              fact(line_at(View, J, _, K, Edge)) ),
            Found),
    sort(Found, Labels).

%!  impossible_drawing(?View, -Junction) is nondet.
%
%   A connected piece of the drawing of View has no legal labelling. Junction is where labels ran out
%   first, or the piece's first junction if each has some left but no choice of them fits all.

impossible_drawing(View, Junction) :-
    fact(view(View, _)),
    view_labels(View, labelled(_, Impossible)),
    member(Junction, Impossible).

view_labels(View, Found) :-
    recall(line_labels, drawing, View, labels, Found, labels_of_view(View, Found)).

labels_of_view(View, Found) :-
    findall(corner(J, Type, Fars),
            ( fact(junction(View, J, Type)),
              findall(I-K, fact(line_at(View, J, I, K, _)), Numbered),
              keysort(Numbered, Ordered),
              pairs_values(Ordered, Fars) ),
            Corners),
    findall(J-K, fact(contour(View, J, K)), Contour),
    drawing_labels(Corners, Contour, Found).

%!  drawing_labels(+Corners, +Contour, -Found) is det.
%
%   Corners are corner(Name, Type, Fars): at the junction Name of that Type lines go to Fars, named
%   counter-clockwise from the widest gap. Contour has From-To for lines beyond which, to the left,
%   there is nothing of what is drawn: they occlude. Found is labelled(Lines, Impossible): Lines are
%   line(From, To, Label) where all labellings agree, Impossible are as in impossible_drawing/2.

drawing_labels(Corners, Contour, labelled(Lines, Impossible)) :-
    pieces(Corners, Pieces),
    maplist(piece_labels(Contour), Pieces, Found),
    findall(Line, ( member(labels(Of), Found), member(Line, Of) ), Lines),
    findall(Name, member(impossible(Name), Found), Impossible).

%   The corners in groups that lines connect.
pieces(Corners, Pieces) :-
    findall(J-K, ( member(corner(J, _, Fars), Corners), member(K, Fars) ), Links),
    findall(J, member(corner(J, _, _), Corners), Names),
    vertices_edges_to_ugraph(Names, Links, Graph),
    findall(J-Corner, ( member(Corner, Corners), Corner = corner(J, _, _) ), Pairs),
    list_to_assoc(Pairs, Of),
    pieces_of(Names, Graph, Of, Pieces).

pieces_of([], _, _, []).
pieces_of([Name|Names], Graph, Of, [Piece|Pieces]) :-
    reachable(Name, Graph, Within),
    findall(Corner, ( member(J, Within), get_assoc(J, Of, Corner) ), Piece),
    subtract(Names, Within, Others),
    pieces_of(Others, Graph, Of, Pieces).

                 /*******************************
                 *    FILTERING AND SEARCHING   *
                 *******************************/

%   Labels that a line may still have stand in an assoc under From-To, From before To in the order of
%   terms, as From calls them.

piece_labels(Contour, Piece, Found) :-
    findall(J-Corner, ( member(Corner, Piece), Corner = corner(J, _, _) ), Pairs),
    list_to_assoc(Pairs, Of),
    first_labels(Piece, Contour, Any),
    filter(Piece, Of, Any, Filtered),
    (   Filtered = emptied(Name)
    ->  Found = impossible(Name)
    ;   Filtered = left(Labels),
        solved(Of, Labels, Solution)
    ->  assoc_to_list(Labels, Lines),
        findall(Line, agreed(Lines, Of, Labels, Solution, Line), Agreed),
        Found = labels(Agreed)
    ;   Piece = [corner(First, _, _)|_],
        Found = impossible(First)
    ).

first_labels(Piece, Contour, Labels) :-
    findall(J-K-[convex, concave, out, in],
            ( member(corner(J, _, Fars), Piece),
              member(K, Fars),
              J @< K ),
            Lines),
    list_to_assoc(Lines, Any),
    foldl(occluding, Contour, Any, Labels).

occluding(J-K, Labels0, Labels) :-
    ( J @< K -> Line = J-K, Label = out ; Line = K-J, Label = in ),
    (   get_assoc(Line, Labels0, _)
    ->  put_assoc(Line, Labels0, [Label], Labels)
    ;   Labels = Labels0                % of another piece
    ).

%!  filter(+Queue, +Of, +Labels, -Filtered) is det.
%
%   Waltz's filter: each corner of Queue strikes out what none of its legal labellings has, and calls
%   its neighbours where it did. Filtered is left(Labels), or emptied(Corner) for the first corner
%   that has no labelling left.

filter([], _, Labels, left(Labels)).
filter([corner(J, Type, Fars)|Queue], Of, Labels, Filtered) :-
    (   \+ catalogued(Type)
    ->  filter(Queue, Of, Labels, Filtered)
    ;   maplist(labels_at(J, Labels), Fars, Before),
        findall(Choice, ( legal(Type, Choice), maplist(memberchk, Choice, Before) ), Choices),
        (   Choices == []
        ->  Filtered = emptied(J)
        ;   columns(Choices, Columns),
            foldl(narrowed(J, Of), Fars, Before, Columns, Labels-Queue, Fewer-Longer),
            filter(Longer, Of, Fewer, Filtered)
        )
    ).

%   Where more than three lines meet, more than three faces do: anything may be.
catalogued(Type) :-
    legal(Type, _),
    !.

labels_at(J, Labels, K, Found) :-
    (   J @< K
    ->  get_assoc(J-K, Labels, Found)
    ;   get_assoc(K-J, Labels, There),
        maplist(across, There, Found)
    ).

columns(Choices, Columns) :-
    Choices = [First|_],
    findall(Column,
            ( nth1(I, First, _),
              findall(Label, ( member(Choice, Choices), nth1(I, Choice, Label) ), Labels),
              sort(Labels, Column) ),
            Columns).

narrowed(J, Of, K, Before, Column, Labels0-Queue0, Labels-Queue) :-
    length(Before, Count),
    (   length(Column, Count)
    ->  Labels = Labels0, Queue = Queue0
    ;   set_labels(J, K, Column, Labels0, Labels),
        get_assoc(K, Of, Neighbour),
        Queue = [Neighbour|Queue0]
    ).

set_labels(J, K, Column, Labels0, Labels) :-
    (   J @< K
    ->  put_assoc(J-K, Labels0, Column, Labels)
    ;   maplist(across, Column, There),
        put_assoc(K-J, Labels0, There, Labels)
    ).

%!  solved(+Of, +Labels, -Solution) is semidet.
%
%   Solution has one label for each line: a legal labelling within Labels, which are filtered.

solved(Of, Labels, Solution) :-
    gen_assoc(Line, Labels, [_, _|_]),
    !,
    get_assoc(Line, Labels, Open),
    member(Label, Open),
    chosen(Line, Label, Of, Labels, Fewer),
    solved(Of, Fewer, Solution),
    !.
solved(_, Solution, Solution).

%   What is left once the line has that label.
chosen(J-K, Label, Of, Labels, Fewer) :-
    put_assoc(J-K, Labels, [Label], One),
    get_assoc(J, Of, From),
    get_assoc(K, Of, To),
    filter([From, To], Of, One, left(Fewer)).

%   A line whose every possible label shows the same: one labelling has that, none another.
agreed(Lines, Of, Labels, Solution, line(J, K, Shown)) :-
    member(J-K-Open, Lines),
    get_assoc(J-K, Solution, [Label]),
    shows(Label, Shown),
    \+ ( member(Other, Open),
         \+ shows(Other, Shown),
         chosen(J-K, Other, Of, Labels, Fewer),
         solved(Of, Fewer, _) ).

shows(convex,  convex).
shows(concave, concave).
shows(out,     occluding).
shows(in,      occluding).
