% Line labels: drawings by hand, and the filter against plain enumeration of all labellings.
:- use_module(library(plunit)).
:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(library(random)).
:- use_module(facetlog(line_labels)).
:- use_module(facetlog_kb(scene)).

% A cube from above and in front: its nearest corner m, and round it a .. f, clockwise as one sees it,
% a at the top; a, c and e are joined to m. Lines run counter-clockwise from the widest gap.
cube([ corner(a, arrow, [f, m, b]),
       corner(b, l, [a, c]),
       corner(c, arrow, [b, m, d]),
       corner(d, l, [c, e]),
       corner(e, arrow, [d, m, f]),
       corner(f, l, [e, a]),
       corner(m, fork, [a, e, c]) ]).

outline([a-b, b-c, c-d, d-e, e-f, f-a]).

label(Lines, J-K, Label) :-
    ( memberchk(line(J, K, Label0), Lines) ; memberchk(line(K, J, Label0), Lines) ),
    !,
    Label = Label0.

:- begin_tests(line_labels).

test(a_floating_cube_has_three_convex_lines_and_an_occluding_outline) :-
    cube(Corners),
    outline(Outline),
    drawing_labels(Corners, Outline, labelled(Lines, [])),
    length(Lines, 9),
    forall(member(K, [a, c, e]), label(Lines, m-K, convex)),
    forall(member(J-K, Outline), label(Lines, J-K, occluding)).

test(without_an_outline_a_cube_may_stand_on_a_ground_or_hang_at_a_wall) :-
    cube(Corners),
    drawing_labels(Corners, [], labelled(Lines, [])),
    forall(member(K, [a, c, e]), label(Lines, m-K, convex)),
    outline(Outline),
    forall(member(J-K, Outline), \+ label(Lines, J-K, _)).

test(two_lines_of_the_outline_may_be_concave_where_the_cube_is_fixed_to_a_wall) :-
    cube(Corners),
    Known = [f-a, a-b, d-e, e-f],
    drawing_labels(Corners, Known, labelled(Lines, [])),
    \+ label(Lines, c-d, _),
    plain(Corners, Known, Solutions),
    member(Solution, Solutions),
    subset([b-c-concave, c-d-concave], Solution),
    !.

test(a_cube_whose_nearest_corner_is_an_arrow_is_impossible, Impossible == [m]) :-
    cube(Corners0),
    selectchk(corner(m, fork, Fars), Corners0, corner(m, arrow, Fars), Corners1),
    selectchk(corner(a, arrow, Of), Corners1, corner(a, fork, Of), Corners),
    outline(Outline),
    drawing_labels(Corners, Outline, labelled([], [Where])),
    ( memberchk(corner(Where, _, _), Corners) -> Impossible = [m] ; Impossible = [] ).

test(the_bar_of_a_t_occludes_and_its_stem_is_left_open) :-
    Corners = [ corner(t, t, [p, s, q]), corner(p, end, [t]), corner(q, end, [t]),
                corner(s, end, [t]) ],
    drawing_labels(Corners, [], labelled(Lines, [])),
    label(Lines, t-p, occluding),
    label(Lines, t-q, occluding),
    \+ label(Lines, t-s, _).

test(what_is_impossible_leaves_other_bodies_their_labels) :-
    cube(Corners),
    outline(Outline),
    Odd = [ corner(x, l, [y, z]), corner(y, l, [z, x]), corner(z, l, [x, y]) ],
    append(Corners, Odd, All),
    append([x-y, z-y, x-z], Outline, Contour),
    drawing_labels(All, Contour, labelled(Lines, [Impossible])),
    memberchk(Impossible, [x, y, z]),
    length(Lines, 9).

test(four_lines_at_a_corner_may_be_anything) :-
    Ends = [p, q, r, s],
    findall(corner(E, end, [k]), member(E, Ends), Corners),
    drawing_labels([corner(k, k, Ends)|Corners], [], labelled([], [])).

test(no_lines_have_no_labels, Found == labelled([], [])) :-
    drawing_labels([], [], Found).

test(the_filter_agrees_with_plain_enumeration, forall(between(1, 60, Seed))) :-
    set_random(seed(Seed)),
    random_drawing(Corners, Contour),
    drawing_labels(Corners, Contour, labelled(Lines, Impossible)),
    plain(Corners, Contour, Solutions),
    (   Solutions == []
    ->  Impossible \== []
    ;   Impossible == [],
        findall(line(J, K, Label), plain_label(Solutions, J, K, Label), Expected),
        sort(Expected, Sorted),
        sort(Lines, Sorted)
    ).

%   A cube's lines with random junctions, some of its outline given.
random_drawing(Corners, Contour) :-
    cube(Cube),
    maplist(changed, Cube, Corners),
    outline(Outline),
    include([_]>>( random(X), X < 0.3 ), Outline, Contour).

changed(corner(J, Type0, Fars0), corner(J, Type, Fars)) :-
    random(X),
    (   X < 0.7
    ->  Type = Type0, Fars = Fars0
    ;   Fars0 = [A, B, C]
    ->  random_member(Type, [arrow, fork, t, multi]),
        random_member(Fars, [[A, B, C], [B, C, A], [C, A, B]])
    ;   Fars0 = [A, B],
        random_member(Type, [l, straight]),
        random_member(Fars, [[A, B], [B, A]])
    ).

plain_label([Solution|Solutions], J, K, Shown) :-
    member(J-K-Label, Solution),
    shown(Label, Shown),
    forall(member(Other, Solutions), ( memberchk(J-K-Label2, Other), shown(Label2, Shown) )).

shown(convex, convex).
shown(concave, concave).
shown(out, occluding).
shown(in, occluding).

flipped(convex, convex).
flipped(concave, concave).
flipped(out, in).
flipped(in, out).

plain(Corners, Contour, Solutions) :-
    findall(J-K-_, ( member(corner(J, _, Fars), Corners), member(K, Fars), J @< K ), Lines),
    findall(Lines, plain_solution(Corners, Contour, Lines), Solutions).

plain_solution(Corners, Contour, Lines) :-
    maplist(plain_corner(Lines), Corners),
    forall(member(J-K, Contour), seen_from(J, Lines, K, out)),
    maplist([_-Label]>>flipped(Label, _), Lines).

plain_corner(Lines, corner(J, Type, Fars)) :-
    (   Type == multi
    ->  true
    ;   legal(Type, Labels),
        maplist(seen_from(J, Lines), Fars, Labels)
    ).

seen_from(J, Lines, K, Label) :-
    (   J @< K
    ->  memberchk(J-K-Label, Lines)
    ;   flipped(Label0, Label),
        memberchk(K-J-Label0, Lines)
    ).

:- end_tests(line_labels).
